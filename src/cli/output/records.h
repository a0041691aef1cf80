// The JSON objects that a command prints, as whoever reads them wants them: whole, narrowed to a
// few fields, as rows of a table, or in a text of one's own.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/json.h"
#include "base/result.h"

namespace fleetpub::cli {

enum class Format { kText, kJson, kCsv, kTsv, kTemplate, kOpenMetrics };

/// Of `fleet` alone.
inline constexpr std::string_view kOpenMetrics = "openmetrics";
/// What begins the value of `--output` before a text of one's own.
inline constexpr std::string_view kTemplatePrefix = "template=";

/// `text`, `csv`, `template=…`.
[[nodiscard]] Format FindFormat(std::string_view output);

class Records {
 public:
  /// Every object as it is.
  Records() = default;

  /// `fields` are names with commas between them (`target,actions.0.type`); empty: all. `columns`
  /// are the members that the command's objects may have; empty: nobody knows. Errors:
  /// ErrorKind::kUsage: a field that no object has, a template with a brace too many.
  [[nodiscard]] static Result<Records> Make(std::string_view output, std::string_view fields,
                                            std::vector<std::string> columns);

  /// The object's lines, with the heading before the first one. Empty for an object that is no row,
  /// such as a summary; nothing: it is shown as it is.
  [[nodiscard]] std::optional<std::string> Render(std::string_view json);

 private:
  struct Part {
    std::string text;
    bool is_field = false;
  };

  [[nodiscard]] Status ParseTemplate(std::string_view text);
  [[nodiscard]] Status CheckFields() const;
  [[nodiscard]] bool IsRow(const base::JsonValue& object) const;
  [[nodiscard]] std::string Row(const std::vector<std::string>& cells) const;
  [[nodiscard]] std::string Narrowed(const base::JsonValue& object) const;
  [[nodiscard]] std::string Filled(const base::JsonValue& object) const;

  Format format_ = Format::kText;
  std::vector<std::string> fields_;
  std::vector<std::string> columns_;
  std::vector<Part> parts_;  // of a template
  bool has_heading_ = false;
};

}  // namespace fleetpub::cli
