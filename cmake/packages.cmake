# Debian packages: cpack -G DEB in a build that was configured with -DVOILE_NATIVE=OFF -DCMAKE_INSTALL_PREFIX=/usr, and
# -DVOILE_V3=ON for the program and the library once more for processors with AVX2. The program (src/cli/faster_program.hpp) and
# the dynamic linker choose.
option(VOILE_V3 "Build the program and the library once more for x86-64-v3" OFF)
if(VOILE_V3)
  include(ExternalProject)
  ExternalProject_Add(voile_v3 SOURCE_DIR ${CMAKE_SOURCE_DIR} BINARY_DIR ${CMAKE_BINARY_DIR}/v3 INSTALL_COMMAND "" BUILD_ALWAYS ON
                      CMAKE_ARGS -DCMAKE_BUILD_TYPE=${CMAKE_BUILD_TYPE} -DCMAKE_INSTALL_PREFIX=${CMAKE_INSTALL_PREFIX}
                                 -DVOILE_NATIVE=OFF -DVOILE_TESTS=OFF -DCMAKE_CXX_FLAGS=-march=x86-64-v3
                                 -DCMAKE_EXE_LINKER_FLAGS=-s -DCMAKE_SHARED_LINKER_FLAGS=-s
                                 -DCMAKE_C_COMPILER_LAUNCHER=${CMAKE_C_COMPILER_LAUNCHER}
                                 -DCMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER}
                      BUILD_COMMAND ${CMAKE_COMMAND} --build . --target voile voile_shared)
  install(PROGRAMS ${CMAKE_BINARY_DIR}/v3/voile DESTINATION bin RENAME voile-x86-64-v3 COMPONENT voile)
  install(PROGRAMS ${CMAKE_BINARY_DIR}/v3/libvoile.so.${PROJECT_VERSION} RENAME libvoile.so.${PROJECT_VERSION_MAJOR}
          DESTINATION ${CMAKE_INSTALL_LIBDIR}/glibc-hwcaps/x86-64-v3 COMPONENT voile)
endif()
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME voile)
set(CPACK_PACKAGE_VENDOR Voile)
set(CPACK_PACKAGE_CONTACT "Voile developers <voile@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Large deflections of thin shells and fabrics, in parallel")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL voile python3 examples)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# The Python binding needs libvoile, which lies in no package yet when its dependencies are found.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR})

set(CPACK_DEBIAN_VOILE_PACKAGE_NAME voile)
set(CPACK_DEBIAN_VOILE_PACKAGE_DEPENDS "openmpi-bin, libopenblas0-pthread")
set(CPACK_DEBIAN_VOILE_PACKAGE_SUGGESTS "python3-voile, voile-examples, ffmpeg")
set(CPACK_COMPONENT_VOILE_DESCRIPTION "The programs, fabrics and templates: voile run, check, render, view, manikin.")

set(CPACK_DEBIAN_PYTHON3_PACKAGE_NAME python3-voile)
set(CPACK_DEBIAN_PYTHON3_PACKAGE_SECTION python)
math(EXPR next_python "${Python3_VERSION_MINOR} + 1")
set(same_version "voile (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_PYTHON3_PACKAGE_DEPENDS "${same_version}, python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next_python}), python3-numpy, python3-h5py")
set(CPACK_DEBIAN_PYTHON3_PACKAGE_SUGGESTS "python3-mpi4py, python3-petsc4py")
set(CPACK_COMPONENT_PYTHON3_DESCRIPTION "The Python package: results, cases, runs and simulations.")

set(CPACK_DEBIAN_EXAMPLES_PACKAGE_NAME voile-examples)
set(CPACK_DEBIAN_EXAMPLES_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_EXAMPLES_PACKAGE_DEPENDS "voile (>= ${PROJECT_VERSION})")
set(CPACK_COMPONENT_EXAMPLES_DESCRIPTION "Worked cases with their meshes, and the documentation.")

if(TARGET voile_shared)
  list(APPEND CPACK_COMPONENTS_ALL dev)
  set(CPACK_DEBIAN_DEV_PACKAGE_NAME libvoile-dev)
  set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
  set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "${same_version}, petsc-dev, libopenmpi-dev")
  set(CPACK_COMPONENT_DEV_DESCRIPTION "Headers, and what lets CMake and pkg-config find the library.")
endif()
include(CPack)
