# Completion of voile's commands and options for bash.
_voile() {
  local word="${COMP_WORDS[COMP_CWORD]}" previous="${COMP_WORDS[COMP_CWORD - 1]}" command="" options i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "${COMP_WORDS[i]}" in run | check | info | reference | init | drape-test | fabric-test | fit | compare | doctor | render | plot | sheet | export | view | manikin) command="${COMP_WORDS[i]}" ;; esac
  done
  case "$previous" in
    --output) mapfile -t COMPREPLY < <(compgen -d -- "$word") && return ;;
    --restart) mapfile -t COMPREPLY < <(compgen -f -X '!*.h5' -- "$word"; compgen -d -- "$word") && return ;;
    --to) mapfile -t COMPREPLY < <(compgen -W "obj stl ply pc2 mdd glb usda msh csv" -- "$word") && return ;;
    --legend) mapfile -t COMPREPLY < <(compgen -W "beside top-left top-right bottom-left bottom-right none" -- "$word") && return ;;
    --log) mapfile -t COMPREPLY < <(compgen -W "x y xy" -- "$word") && return ;;
    --cloth) mapfile -t COMPREPLY < <(compgen -W "plain twill knit" -- "$word") && return ;;
    --quality) mapfile -t COMPREPLY < <(compgen -W "draft final" -- "$word") && return ;;
    --view) mapfile -t COMPREPLY < <(compgen -W "three-quarter front back left right top bottom" -- "$word") && return ;;
    --method) mapfile -t COMPREPLY < <(compgen -W "plate weight" -- "$word") && return ;;
    --kind) mapfile -t COMPREPLY < <(compgen -W "figure form" -- "$word") && return ;;
    --motion) mapfile -t COMPREPLY < <(compgen -W "walk turn" -- "$word") && return ;;
  esac
  case "$command" in
    run) options="--output --overwrite --restart --restart-step --from --set --allow-system-call --quiet --verbose --plain --help" ;;
    check | info) options="--set --allow-system-call --help" ;;
    reference) options="--schema --help" ;;
    doctor) options="--help" ;;
    init) options="--from --example --list --drape --garment --shell --modal --help" ;;
    compare) options="--near --output --overwrite --help" ;;
    drape-test) options="--specimen --repeats --method --elastic --equilibria --folds --no-mesh-check --cell --jobs --output --overwrite --quiet --help" ;;
    fabric-test) options="--output --overwrite --help" ;;
    fit) options="--output --overwrite --repeats --method --cell --jobs --quiet --help" ;;
    render) options="--steps --output --animation --rate --frames --stage --mode --size --quality --threads --field --range --scale --partition --panels --contours --seams --mesh --creases --cloth --print --title --view --eye --target --up --no-stamp --no-ground --no-obstacles --palette --quiet --help" ;;
    view) options="--steps --stage --field --output --rate --no-obstacles --quiet --help" ;;
    sheet) options="--columns --output --palette --quiet --help" ;;
    plot) options="--x --y --curve --dashed --points --labels --x-label --y-label --x-range --y-range --log --equal --legend --title --output --size --quiet --help" ;;
    export) options="--to --steps --stage --output --field --rate --no-obstacles --one-mesh --tolerance --cloth --print --quiet --help" ;;
    manikin) options="--kind --person --height --bust --waist --hip --inseam --arms --size --motion --seconds --fps --speed --cadence --angle --help" ;;
    *) options="run check info reference init drape-test fabric-test fit compare doctor render plot sheet export view manikin --help --version" ;;
  esac
  if [[ "$word" == -* || -z "$command" ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$word")
  else
    mapfile -t COMPREPLY < <(compgen -f -X '!*.@(toml|msh|geo)' -- "$word"; compgen -d -- "$word")
  fi
}
complete -o filenames -F _voile voile
