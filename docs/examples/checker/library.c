/* All functions of the header, for languages that call a shared library:
   cc -std=c99 -O2 -shared -fPIC library.c -o libbicycle.so -lm */
#ifdef _WIN32
#define BICYCLE_API __declspec(dllexport)
#else
#define BICYCLE_API
#endif
#include "uncontrolled_bicycle.h"
