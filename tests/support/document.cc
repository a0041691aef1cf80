#include "support/document.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>

namespace fleetpub::testing {
namespace {

bool IsCommand(const std::string& line) {
  static const std::regex command("(fleetpub|printf|cut|echo|for|scripts/[a-z]+) .*");
  return std::regex_match(line, command);
}

void ReadExamples(Block& block) {
  const bool is_session =
      block.text.starts_with("$ ") || block.text.find("\n$ ") != std::string::npos;
  const std::size_t first = block.text.starts_with("#") ? block.text.find('\n') + 1 : 0;
  if (!is_session && !IsCommand(block.text.substr(first, block.text.find('\n', first) - first)))
    return;
  if (block.text.starts_with("for ")) return block.examples.push_back({block.text, {}});
  std::istringstream lines(block.text);
  bool goes_on = false;
  for (std::string line; std::getline(lines, line);) {
    const bool is_prompt = line.starts_with("$ ");
    if (goes_on) {
      block.examples.back().command += "\n" + line;
    } else if (is_prompt || !is_session) {
      if (!line.empty() && !line.starts_with("#")) {
        block.examples.push_back({is_prompt ? line.substr(2) : line, {}});
      }
    } else {
      block.examples.back().shown.push_back(line);
    }
    goes_on = (is_prompt || !is_session || goes_on) && line.ends_with("\\");
  }
}

}  // namespace

std::string SourceText(const std::string& path) {
  std::ifstream file(FLEETPUB_SOURCE_DIR "/" + path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<Block> IndentedBlocks(const std::string& page) {
  constexpr std::string_view kIndent = "    ";
  std::vector<Block> blocks;
  std::istringstream lines(page);
  std::string chapter;
  std::string blanks;
  bool inside = false;
  bool fenced = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```")) fenced = !fenced;
    if (line.starts_with("#") && !fenced) chapter = line.substr(line.find(' ') + 1);
    if (line.starts_with(kIndent) && !fenced) {
      if (!inside) blocks.push_back({chapter, "", {}});
      blocks.back().text += blanks + line.substr(kIndent.size()) + "\n";
      blanks.clear();
      inside = true;
    } else if (line.empty() && inside) {
      blanks += "\n";
    } else {
      blanks.clear();
      inside = false;
    }
  }
  for (Block& block : blocks) ReadExamples(block);
  return blocks;
}

bool IsShownAs(const std::string& shown, const std::string& line) {
  static const std::pair<std::regex, const char*> kMayDiffer[] = {
      {std::regex(R"([.*+?^${}()|\[\]\\])"), R"(\$&)"},
      {std::regex(" ?… ?"), ".*"},
      {std::regex(" {2,}"), " +"},
      {std::regex(R"([0-9]+(\\\.[0-9]+)? (ms|s|min|h|d)\b)"), R"([0-9.]+ (us|ms|s|min|h|d))"},
      {std::regex(R"(elapsedMs":[0-9]+\\\.[0-9]+)"), R"(elapsedMs":[0-9.]+)"},
      {std::regex(R"(headerId [0-9]+)"), "headerId [0-9]+"},
      {std::regex(R"([0-9]+ messages?, [0-9]+ valid)"), "[0-9]+ messages?, [0-9]+ valid"}};
  std::string pattern = shown;
  for (const auto& [what, with] : kMayDiffer) pattern = std::regex_replace(pattern, what, with);
  return std::regex_match(line, std::regex(pattern));
}

}  // namespace fleetpub::testing
