# Writes OUTPUT, a C++ source with every schema below ROOT: cmake -DROOT=… -DOUTPUT=… -P embed.cmake
#
# The text is embedded without line breaks and indentation: it is parsed at each start of the program. A JSON string
# cannot contain a line break, so nothing that means something is lost.

set(entries "")
file(GLOB_RECURSE files RELATIVE ${ROOT} ${ROOT}/*.schema.json ${ROOT}/*.openapi.json)
list(SORT files)
foreach(file IN LISTS files)
  string(REGEX REPLACE "\\.(schema|openapi)\\.json$" "" name "${file}")
  file(READ ${ROOT}/${file} text)
  string(REGEX REPLACE "\r?\n[ \t]*" "" text "${text}")
  string(APPEND entries "    {\"${name}\",\n     R\"json(${text})json\"},\n")
endforeach()

file(WRITE ${OUTPUT} "// Made from the schemas folder by schema/embed.cmake.
#include <array>

#include \"schema/schema.h\"

namespace fleetpub::schema {
namespace {

constexpr auto kSchemas = std::to_array<Embedded>({
${entries}});

}  // namespace

std::span<const Embedded> EmbeddedSchemas() { return kSchemas; }

}  // namespace fleetpub::schema
")
