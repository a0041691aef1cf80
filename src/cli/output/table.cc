#include "cli/output/table.h"

#include <unistd.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "base/width.h"

namespace fleetpub::cli {
namespace {

using Widths = std::vector<std::size_t>;

constexpr std::size_t kGap = 2;

Widths NaturalWidths(std::span<const Column> columns, std::span<const Row> rows) {
  Widths widths;
  for (const Column& column : columns) widths.push_back(base::MeasureWidth(column.name));
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < widths.size(); ++i) {
      widths[i] = std::max(widths[i], base::MeasureWidth(row[i].text));
    }
  }
  return widths;
}

// Which columns are shown, and how wide.
class Layout {
 public:
  Layout(std::span<const Column> columns, Widths widths, std::size_t room)
      : columns_(columns), widths_(std::move(widths)), shown_(columns.size()) {
    std::iota(shown_.begin(), shown_.end(), 0U);
    while (Total(true) > room && DropOne()) {
    }
    for (auto i = shown_.rbegin(); i != shown_.rend(); ++i) {
      const std::size_t total = Total(false);
      if (total <= room) break;
      widths_[*i] -= std::min(widths_[*i] - Least(*i), total - room);
    }
  }

  [[nodiscard]] std::string Line(const Row& row, std::size_t room, const Output& output) const {
    std::string line;
    for (std::size_t at = 0; at < shown_.size() && room > 0; ++at) {
      const std::size_t i = shown_[at];
      const std::string fitting = base::Shortened(widths_[i], row[i].text);
      const std::string_view text = base::CutTo(room, fitting);
      const std::size_t taken = base::MeasureWidth(text);
      std::size_t blanks = std::min(widths_[i] - std::min(widths_[i], taken), room - taken);
      room -= taken + blanks;
      if (columns_[i].is_number) line.append(std::exchange(blanks, 0), ' ');
      line += output.Toned(row[i].tone, text);
      if (at + 1 == shown_.size()) break;
      const std::size_t gap = std::min(kGap, room);
      line.append(blanks + gap, ' ');
      room -= gap;
    }
    return line;
  }

 private:
  [[nodiscard]] std::size_t Least(std::size_t i) const {
    const std::size_t least = columns_[i].least;
    return least == 0 ? widths_[i] : std::min(widths_[i], least);
  }

  [[nodiscard]] std::size_t Total(bool least) const {
    std::size_t total = kGap * (shown_.size() - 1);
    for (const std::size_t i : shown_) total += least ? Least(i) : widths_[i];
    return total;
  }

  bool DropOne() {
    const auto rank = [this](std::size_t a, std::size_t b) {
      return columns_[a].rank < columns_[b].rank;
    };
    const auto last = std::max_element(shown_.begin(), shown_.end(), rank);
    if (columns_[*last].rank == 0) return false;
    shown_.erase(last);
    return true;
  }

  std::span<const Column> columns_;
  Widths widths_;
  Widths shown_;
};

Row MakeHeader(std::span<const Column> columns) {
  Row row;
  for (const Column& column : columns) row.push_back({column.name});
  return row;
}

}  // namespace

std::vector<std::string> TableLines(std::span<const Column> columns, std::span<const Row> rows,
                                    std::size_t width, const Output& output, Widths* widths) {
  Widths natural = NaturalWidths(columns, rows);
  if (widths != nullptr) {
    widths->resize(natural.size());
    for (std::size_t i = 0; i < natural.size(); ++i) {
      natural[i] = (*widths)[i] = std::max(natural[i], (*widths)[i]);
    }
  }
  const Layout layout(columns, std::move(natural), width);
  std::vector<std::string> lines;
  lines.reserve(rows.size() + 1);
  lines.push_back(layout.Line(MakeHeader(columns), width, output));
  for (const Row& row : rows) lines.push_back(layout.Line(row, width, output));
  return lines;
}

void PrintTable(std::span<const Column> columns, std::span<const Row> rows, Output& output) {
  const auto lines = TableLines(columns, rows, TerminalWidth(STDOUT_FILENO), output);
  output.PeopleLine(lines.front());
  for (const std::string& line : std::span(lines).subspan(1)) output.Line(line);
}

}  // namespace fleetpub::cli
