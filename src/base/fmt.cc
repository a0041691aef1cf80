// fmt's compiled part, for the builds that do not load its shared library (src/CMakeLists.txt).
#include <fmt/format-inl.h>
