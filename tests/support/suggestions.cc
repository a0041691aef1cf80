#include "support/suggestions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>

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

namespace {

// The literal that goes on here, with those behind it.
std::string ReadLiteral(std::string_view code) {
  std::string text;
  for (std::size_t i = 0; i < code.size(); ++i) {
    if (code[i] == '"') {
      i = code.find_first_not_of(" \n", i + 1);
      if (i == std::string_view::npos || code[i] != '"') break;
    } else if (code[i] == '\\') {
      text += code[++i] == 'n' ? '\n' : code[i];
    } else {
      text += code[i];
    }
  }
  return text;
}

std::string Filled(const std::string& text) {
  static const std::regex kPlaceholder(R"(\{\d*\})");
  return std::regex_replace(text, kPlaceholder, "42");
}

void AddSuggestions(std::string_view code, std::string_view mark, std::vector<std::string>& found) {
  for (auto at = code.find(mark); at != std::string_view::npos; at = code.find(mark, at + 1)) {
    const auto line = code.substr(code.rfind('\n', at) + 1);
    const auto first = line.find_first_not_of(' ');
    if (line.substr(first).starts_with("//") || std::isalpha(code[at - 1]) != 0) continue;
    const std::string text = Filled(ReadLiteral(code.substr(at + mark.size())));
    found.push_back(text.substr(0, text.find('\n')));
  }
}

}  // namespace

std::vector<std::string> FindSuggestionsInSources() {
  std::vector<std::string> found;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(FLEETPUB_SOURCE_DIR "/src")) {
    const std::string path = entry.path().string();
    if (!path.ends_with(".cc") && !path.ends_with(".h")) continue;
    std::ifstream stream(entry.path());
    const std::string code{std::istreambuf_iterator<char>(stream), {}};
    AddSuggestions(code, "try: ", found);
    std::vector<std::string> commands;
    AddSuggestions(code, "TryCommand(\"", commands);
    for (const std::string& command : commands) found.push_back("fleetpub " + command);
  }
  std::erase(found, "fleetpub ");  // TryCommand's own, which callers complete
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
