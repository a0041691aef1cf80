#include "cli/toml_text.h"

#include <fmt/format.h>

#include <cmath>
#include <exception>
#include <sstream>

#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 1
#include <toml++/toml.h>

#include "base/json.h"
#include "base/text.h"

namespace fleetpub::cli {
namespace {

using base::JsonString;

// The library stops at 256 tables in each other, which bounds this recursion too.
class Writer {
 public:
  // False when `fault` says what JSON cannot hold.
  bool Write(const toml::node& node) {
    if (const auto* table = node.as_table()) return Table(*table);
    if (const auto* array = node.as_array()) return Array(*array);
    if (const auto* text = node.as_string()) return Put(JsonString(text->get()));
    if (const auto* number = node.as_integer()) return Put(fmt::format("{}", number->get()));
    if (const auto* flag = node.as_boolean()) return Put(flag->get() ? "true" : "false");
    if (const auto* number = node.as_floating_point()) return Number(node, number->get());
    std::ostringstream time;
    if (const auto* date = node.as_date()) time << date->get();
    if (const auto* clock = node.as_time()) time << clock->get();
    if (const auto* moment = node.as_date_time()) time << moment->get();
    return Put(JsonString(time.str()));
  }

  std::string json;
  std::string fault;

 private:
  bool Put(std::string_view text) {
    json += text;
    return true;
  }

  bool Table(const toml::table& table) {
    json += '{';
    for (const auto& [key, value] : table) {
      if (json.back() != '{') json += ',';
      json += JsonString(key.str()) + ":";
      if (!Write(value)) return false;
    }
    return Put("}");
  }

  bool Array(const toml::array& array) {
    json += '[';
    for (const auto& value : array) {
      if (json.back() != '[') json += ',';
      if (!Write(value)) return false;
    }
    return Put("]");
  }

  bool Number(const toml::node& node, double number) {
    if (std::isfinite(number)) return Put(fmt::format("{}", number));
    fault = fmt::format("line {}: JSON has no such number as {}", node.source().begin.line, number);
    return false;
  }
};

}  // namespace

Result<std::string> TomlToJson(std::string_view text) {
  try {
    const toml::table table = toml::parse(text);
    Writer writer;
    if (!writer.Write(table)) return Fail(ErrorKind::kInvalid, std::move(writer.fault));
    return std::move(writer.json);
  } catch (const toml::parse_error& error) {
    return Fail(ErrorKind::kInvalid,
                fmt::format("line {}: not valid TOML: {}", error.source().begin.line,
                            base::Printable(error.description())));
  } catch (const std::exception& error) {
    return Fail(ErrorKind::kInvalid,
                fmt::format("not valid TOML: {}", base::Printable(error.what())));
  }
}

}  // namespace fleetpub::cli
