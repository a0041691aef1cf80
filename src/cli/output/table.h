// Rows with aligned columns, in as much room as there is.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "cli/output/output.h"

namespace fleetpub::cli {

struct Cell {
  std::string text;  ///< printable
  Tone tone = Tone::kPlain;
};

using Row = std::vector<Cell>;

struct Column {
  const char* name;
  /// When there is not room for all columns, those of the highest rank go first; 0: it stays.
  int rank = 0;
  /// It may be cut to so many characters before a column goes; 0: it is not cut.
  std::size_t least = 0;
  bool is_number = false;  ///< flush right
};

/// The first row names the columns; then one line for each row, none wider than `width`. A column
/// is no narrower than `widths` says, which remembers how wide it was: of a table that is drawn
/// again and again the columns stand still.
[[nodiscard]] std::vector<std::string> TableLines(std::span<const Column> columns,
                                                  std::span<const Row> rows, std::size_t width,
                                                  const Output& output,
                                                  std::vector<std::size_t>* widths = nullptr);

/// Prints it, as wide as standard output's terminal; anywhere else in full. The names of the
/// columns are only for people.
void PrintTable(std::span<const Column> columns, std::span<const Row> rows, Output& output);

}  // namespace fleetpub::cli
