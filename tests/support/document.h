// A page of docs/, and what stands in it to be tried.
#pragma once

#include <string>
#include <vector>

namespace fleetpub::testing {

/// A command as the page shows it, continued lines joined, and the lines shown below it.
struct Example {
  std::string command;
  std::vector<std::string> shown;
};

/// An indented block: commands, or something else, such as a configuration.
struct Block {
  std::string chapter;  ///< the heading above it
  std::string text;     ///< without its indentation
  std::vector<Example> examples;
};

/// The text of a file below the source's folder.
[[nodiscard]] std::string SourceText(const std::string& path);

/// The page's indented blocks. A block in which a line begins with `$ ` shows a session: that line
/// is a command, what follows its output. One that begins with a command has nothing but commands.
[[nodiscard]] std::vector<Block> IndentedBlocks(const std::string& page);

/// Whether `line` is what a page's line shows: times, header ids and counts may differ, as may the
/// number of blanks between columns, and `…` stands for anything.
[[nodiscard]] bool IsShownAs(const std::string& shown, const std::string& line);

}  // namespace fleetpub::testing
