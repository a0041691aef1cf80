#include "base/csv.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"

namespace fleetpub::base {
namespace {

class Reader {
 public:
  explicit Reader(std::string_view text) : rest_(WithoutByteOrderMark(text)) {}

  Result<std::vector<CsvRow>> Rows() {
    std::vector<CsvRow> rows;
    while (!rest_.empty()) {
      CsvRow row{line_, {}};
      if (auto read = Row(row); !read) return Fail(std::move(read.error()));
      const bool blank = row.fields.size() == 1 && row.fields[0].empty();
      if (!blank) rows.push_back(std::move(row));
    }
    return rows;
  }

 private:
  [[nodiscard]] tl::unexpected<Error> Refuse(std::size_t line, std::string_view what) const {
    return Fail(ErrorKind::kInvalid, fmt::format("line {}: {}", line, what));
  }

  // Up to and with the end of its line.
  Status Row(CsvRow& row) {
    while (true) {
      auto field = rest_.starts_with('"') ? Quoted() : Plain();
      if (!field) return Fail(std::move(field.error()));
      if (!IsUtf8(*field)) return Refuse(row.line, "it is not valid UTF-8");
      row.fields.push_back(*std::move(field));
      if (rest_.starts_with(',')) {
        rest_.remove_prefix(1);
        continue;
      }
      if (rest_.starts_with("\r\n")) rest_.remove_prefix(1);
      if (rest_.empty()) return {};
      if (!rest_.starts_with('\n')) {
        return Refuse(line_, "after a closing quotation mark comes a comma or the line's end");
      }
      rest_.remove_prefix(1);
      ++line_;
      return {};
    }
  }

  Result<std::string> Plain() {
    std::size_t end = std::min(rest_.find_first_of(",\n"), rest_.size());
    if (end > 0 && rest_[end - 1] == '\r' && (end == rest_.size() || rest_[end] == '\n')) --end;
    std::string field(rest_.substr(0, end));
    rest_.remove_prefix(end);
    if (rest_ == "\r") rest_ = {};
    return field;
  }

  Result<std::string> Quoted() {
    const std::size_t begun = line_;
    std::string field;
    rest_.remove_prefix(1);
    while (true) {
      const std::size_t mark = rest_.find('"');
      if (mark == std::string_view::npos) {
        return Refuse(begun, "a quotation mark is not closed");
      }
      field += rest_.substr(0, mark);
      for (const char c : rest_.substr(0, mark)) line_ += c == '\n' ? 1U : 0U;
      rest_.remove_prefix(mark + 1);
      if (!rest_.starts_with('"')) return field;
      field += '"';
      rest_.remove_prefix(1);
    }
  }

  std::string_view rest_;
  std::size_t line_ = 1;
};

}  // namespace

Result<std::vector<CsvRow>> ParseCsv(std::string_view text) { return Reader(text).Rows(); }

}  // namespace fleetpub::base
