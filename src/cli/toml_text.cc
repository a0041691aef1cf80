#include "cli/toml_text.h"

#include <fmt/format.h>

#include <cmath>
#include <exception>
#include <sstream>
#include <stdexcept>

namespace fleetpub::cli {
// The library asserts things about times that a file can break (`1979-05-27Tx:00`): an error of the
// file then, in every build, instead of an abort or of undefined behaviour.
constexpr void RequireOfToml(bool holds) {
  if (!holds) throw std::invalid_argument("a date or time that is none");
}
}  // namespace fleetpub::cli

#undef NDEBUG
#define TOML_ASSERT(holds) fleetpub::cli::RequireOfToml(static_cast<bool>(holds))
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

TomlPlace PlaceOf(const toml::source_region& source) {
  return {source.begin.line, source.begin.column};
}

TomlValue ValueOf(const toml::node& node) {
  using Type = TomlValue::Type;
  TomlValue value{.type = Type::kTime, .place = PlaceOf(node.source())};
  if (const auto* table = node.as_table()) {
    value.type = Type::kTable;
    for (const auto& [key, member] : *table) {
      value.members.push_back({std::string(key.str()), PlaceOf(key.source()), ValueOf(member)});
    }
  } else if (const auto* array = node.as_array()) {
    value.type = Type::kArray;
    for (const auto& item : *array) value.items.push_back(ValueOf(item));
  } else if (const auto* text = node.as_string()) {
    value.type = Type::kText;
    value.text = text->get();
  } else if (const auto* whole = node.as_integer()) {
    value.type = Type::kInteger;
    value.text = fmt::format("{}", whole->get());
  } else if (const auto* flag = node.as_boolean()) {
    value.type = Type::kBoolean;
    value.text = flag->get() ? "true" : "false";
  } else if (node.is_floating_point()) {
    value.type = Type::kNumber;
  }
  return value;
}

// Whether the library's words on this line may be shown: they can hold a piece of it.
bool MayBeQuoted(std::string_view text, std::size_t line) {
  const auto lines = base::Split(text, '\n');
  if (line == 0 || line > lines.size()) return true;
  return base::ToLower(lines[line - 1]).find("password") == std::string::npos;
}

}  // namespace

Result<TomlValue> ParseToml(std::string_view text) {
  try {
    return ValueOf(toml::parse(text));
  } catch (const toml::parse_error& error) {
    const auto [line, column] = PlaceOf(error.source());
    const std::string what = base::Printable(error.description());
    return Fail(ErrorKind::kUsage, fmt::format("{}:{}: not valid TOML{}", line, column,
                                               MayBeQuoted(text, line) ? ": " + what : ""));
  } catch (const std::exception& error) {
    return Fail(ErrorKind::kUsage, fmt::format("1:1: not valid TOML: {}", error.what()));
  }
}

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
