#include <stdio.h>
__attribute__((constructor)) static void loaded(void) {
  FILE* f = fopen("MARKER", "w");
  if (f) fclose(f);
}
