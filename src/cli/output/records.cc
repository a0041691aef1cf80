#include "cli/output/records.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "base/text.h"

namespace fleetpub::cli {
namespace {

using base::JsonValue;

// What a path such as `actions.0.type` leads to, or null.
const JsonValue* FindValue(const JsonValue& object, std::string_view path) {
  const JsonValue* value = &object;
  for (const std::string& name : base::Split(path, '.')) {
    if (value->IsArray()) {
      rapidjson::SizeType index = 0;
      const char* const end = name.data() + name.size();
      const bool is_index = std::from_chars(name.data(), end, index).ptr == end && !name.empty();
      value = is_index && index < value->Size() ? &(*value)[index] : nullptr;
    } else {
      value = base::FindMember(*value, name);
    }
    if (value == nullptr) return nullptr;
  }
  return value;
}

// A text as it is, everything else as JSON; what is not there, or null, is empty.
std::string CellText(const JsonValue* value) {
  if (value == nullptr || value->IsNull()) return {};
  return value->IsString() ? std::string(base::ToView(*value)) : base::ToJson(*value);
}

// RFC 4180. A text that a spreadsheet would take for a formula gets an apostrophe before it: what
// robots and others write must not be run by whoever opens the file.
std::string CsvCell(const JsonValue* value) {
  std::vector<std::string> lines = base::Split(CellText(value), '\n');
  for (std::string& line : lines) line = base::Printable(line);
  std::string text = base::Join(lines, "\n");
  const bool is_text = value != nullptr && value->IsString();
  if (is_text && text.find_first_of("=+-@") == 0) text.insert(0, "'");
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

// Newline, tab and backslash as `\n`, `\t` and `\\`.
std::string TsvCell(const JsonValue* value) {
  std::string text;
  for (const char c : CellText(value)) text += c == '\\' ? std::string("\\\\") : std::string(1, c);
  return base::Printable(text);
}

}  // namespace

Format FindFormat(std::string_view output) {
  if (output == "json") return Format::kJson;
  if (output == "csv") return Format::kCsv;
  if (output == "tsv") return Format::kTsv;
  if (output == kOpenMetrics) return Format::kOpenMetrics;
  return output.starts_with(kTemplatePrefix) ? Format::kTemplate : Format::kText;
}

Result<Records> Records::Make(std::string_view output, std::string_view fields,
                              std::vector<std::string> columns) {
  Records records;
  records.format_ = FindFormat(output);
  records.columns_ = std::move(columns);
  if (!fields.empty()) records.fields_ = base::Split(fields, ',');
  const Format format = records.format_;
  const bool has_fields =
      format == Format::kJson || format == Format::kCsv || format == Format::kTsv;
  if (!fields.empty() && !has_fields) {
    return Fail(ErrorKind::kUsage, "--fields needs -o json, csv or tsv");
  }
  if (format == Format::kTemplate) {
    if (auto parsed = records.ParseTemplate(output.substr(kTemplatePrefix.size())); !parsed) {
      return Fail(std::move(parsed.error()));
    }
  }
  if (auto right = records.CheckFields(); !right) return Fail(std::move(right.error()));
  return records;
}

// `{name}` is a field, `{{` and `}}` are braces, `\n`, `\t` and `\\` what they are elsewhere.
Status Records::ParseTemplate(std::string_view text) {
  const auto wrong = [](std::string_view why) {
    return Fail(ErrorKind::kUsage,
                fmt::format("-o template: {}; write -o template='{{target}} {{status}}'", why));
  };
  std::string literal;
  while (!text.empty()) {
    const char c = text.front();
    const char next = text.size() > 1 ? text[1] : '\0';
    const bool is_pair = (c == '{' || c == '}') && next == c;
    const bool is_escape = c == '\\' && (next == 'n' || next == 't' || next == '\\');
    if (is_pair || is_escape) {
      literal += is_pair || next == '\\' ? next : next == 'n' ? '\n' : '\t';
      text.remove_prefix(2);
    } else if (c == '{') {
      const std::size_t end = text.find('}');
      if (end == std::string_view::npos || end == 1) return wrong("a { without a name and a }");
      parts_.push_back({std::exchange(literal, {}), false});
      parts_.push_back({std::string(text.substr(1, end - 1)), true});
      fields_.push_back(parts_.back().text);
      text.remove_prefix(end + 1);
    } else if (c == '}') {
      return wrong("a } without a {");
    } else {
      literal += c;
      text.remove_prefix(1);
    }
  }
  parts_.push_back({literal, false});
  return {};
}

Status Records::CheckFields() const {
  for (const std::string& field : fields_) {
    const std::string name = field.substr(0, field.find('.'));
    const bool is_known =
        columns_.empty() || std::find(columns_.begin(), columns_.end(), name) != columns_.end();
    if (!name.empty() && is_known) continue;
    const auto near =
        base::Nearest(name, std::vector<std::string_view>(columns_.begin(), columns_.end()));
    return Fail(ErrorKind::kUsage, fmt::format("no result of this command has a field '{}': {}",
                                               base::Printable(field),
                                               near ? fmt::format("did you mean {}?", *near)
                                                    : "there are " + base::Join(columns_, ", ")));
  }
  return {};
}

// A summary and an error are none.
bool Records::IsRow(const JsonValue& object) const {
  return columns_.empty() ||
         std::any_of(columns_.begin(), columns_.end(), [&](const std::string& column) {
           return base::FindMember(object, column) != nullptr;
         });
}

std::string Records::Row(const std::vector<std::string>& cells) const {
  return base::Join(cells, format_ == Format::kCsv ? "," : "\t") + "\n";
}

std::string Records::Narrowed(const JsonValue& object) const {
  std::string json;
  for (const std::string& field : fields_) {
    const JsonValue* value = FindValue(object, field);
    if (value == nullptr) continue;
    json += fmt::format("{}{}:{}", json.empty() ? "" : ",", base::JsonString(field),
                        base::ToJson(*value));
  }
  return base::ShownJson("{" + json + "}") + "\n";
}

std::string Records::Filled(const JsonValue& object) const {
  std::string line;
  for (const Part& part : parts_) {
    line += part.is_field ? base::Printable(CellText(FindValue(object, part.text))) : part.text;
  }
  return line + "\n";
}

std::optional<std::string> Records::Render(std::string_view json) {
  const bool is_whole = format_ == Format::kJson && fields_.empty();
  if (format_ == Format::kText || is_whole) return std::nullopt;
  const auto object = base::ParseJson(json);
  if (!object || !object->IsObject()) return std::nullopt;
  if (!IsRow(*object)) {
    if (format_ == Format::kJson) return std::nullopt;
    return std::string();
  }
  if (format_ == Format::kJson) return Narrowed(*object);
  if (format_ == Format::kTemplate) return Filled(*object);
  std::string text;
  if (fields_.empty()) fields_ = columns_;
  if (fields_.empty()) {
    for (const auto& member : object->GetObject()) fields_.emplace_back(base::ToView(member.name));
  }
  if (!std::exchange(has_heading_, true)) text = Row(fields_);
  std::vector<std::string> cells;
  for (const std::string& field : fields_) {
    const JsonValue* value = FindValue(*object, field);
    cells.push_back(format_ == Format::kCsv ? CsvCell(value) : TsvCell(value));
  }
  return text + Row(cells);
}

}  // namespace fleetpub::cli
