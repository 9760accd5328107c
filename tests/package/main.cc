// Uses the library as a stranger would: headers and libraries from the installed package alone.
#include <cstdio>

#include "livemvs/core/camera.h"

int main() {
  std::puts("placeholder");
  return 0;
}
