#include "support/suggestions.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "base/text.h"
#include "cli/parser/command_line.h"
#include "support/process.h"

namespace fleetpub::testing {

std::vector<std::string> FindSuggestions(std::string_view text) {
  constexpr std::string_view kMark = "try: ";
  std::vector<std::string> found;
  for (auto at = text.find(kMark); at != std::string_view::npos; at = text.find(kMark, at + 1)) {
    const auto begin = at + kMark.size();
    found.emplace_back(text.substr(begin, text.find('\n', begin) - begin));
  }
  return found;
}

std::vector<std::string> ReadAsShell(const std::string& line) {
  EXPECT_TRUE(line.starts_with("fleetpub ")) << line;
  const std::string words = line.substr(0, std::min(line.find(" <"), line.find(" > ")));
  const Finished read =
      Run({.arguments = {"sh", "-c", "fleetpub() { printf '%s\\0' \"$@\"; }; " + words}});
  EXPECT_EQ(read.exit_code, 0) << line << ": " << read.errors;
  auto arguments = base::Split(read.output, '\0');
  arguments.pop_back();
  return arguments;
}

void ExpectUnderstood(const std::string& line) {
  const auto arguments = ReadAsShell(line);
  cli::CommandLine call;
  const auto asked = call.Read(cli::OptionSet::Extent::kAll, arguments);
  EXPECT_TRUE(asked) << line << ": " << asked.error().message;
}

}  // namespace fleetpub::testing
