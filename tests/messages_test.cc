// Holds docs/messages.md to the source, and the source to it.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "support/document.h"

namespace fleetpub::testing {
namespace {

// Not for a person to act on.
const std::map<std::string, std::string> kNotInTheTable = {
    {"connected in", "a result of ping"},
    {"round trip", "a result of ping"},
    {"reachable  MQTT", "a result of ping"},
    {"publish    not tried: it would reach robots", "a result of ping"},
    {"of the tables", "a detail"},
    {"of the file", "a detail"},
    {"it is no JSON object", "of a robot's message, in docs/robot-words.md"},
    {"1:1: not valid TOML", "a place, then what the table has"},
};

std::string Replaced(std::string text, const std::regex& what, const std::string& with) {
  return std::regex_replace(text, what, with);
}

/// Without comments, and with texts that go on in the next line as one.
std::string CodeOf(const std::filesystem::path& file) {
  const std::string path = std::filesystem::relative(file, FLEETPUB_SOURCE_DIR).string();
  std::istringstream lines(SourceText(path));
  std::string code;
  for (std::string line; std::getline(lines, line);) {
    const auto first = line.find_first_not_of(' ');
    if (first == std::string::npos || line.substr(first).starts_with("//")) continue;
    code += line + "\n";
  }
  return Replaced(code, std::regex("\"\\s*\n\\s*\""), "");
}

std::vector<std::string> TextsIn(const std::string& code) {
  static const std::regex literal(R"re((R?)"((?:[^"\\\n]|\\.)*)")re");
  std::vector<std::string> texts;
  for (std::sregex_iterator it(code.begin(), code.end(), literal), end; it != end; ++it) {
    if ((*it)[1].length() > 0) continue;
    std::string text = Replaced((*it)[2], std::regex(R"(\\(["\\]))"), "$1");
    texts.push_back(Replaced(std::move(text), std::regex(R"(\\n)"), " "));
  }
  return texts;
}

/// The pieces between what differs, as far as they say something.
std::vector<std::string> PiecesOf(const std::string& text, const std::regex& differs) {
  constexpr const char* kEdges = " :;,.";
  std::vector<std::string> pieces;
  for (std::sregex_token_iterator it(text.begin(), text.end(), differs, -1), end; it != end; ++it) {
    std::string piece = it->str();
    piece.erase(0, piece.find_first_not_of(kEdges));
    piece.erase(piece.find_last_not_of(kEdges) + 1);
    if (piece.size() >= 9 && piece.find(' ') != std::string::npos) pieces.push_back(piece);
  }
  return pieces;
}

// A format text's pieces; `{{` is a brace.
std::vector<std::string> PiecesOfFormat(std::string text) {
  text = Replaced(Replaced(std::move(text), std::regex(R"(\{\{)"), "\x01"), std::regex(R"(\}\})"),
                  "\x02");
  auto pieces = PiecesOf(text, std::regex(R"(\{[^}]*\})"));
  for (std::string& piece : pieces) {
    std::replace(piece.begin(), piece.end(), '\x01', '{');
    std::replace(piece.begin(), piece.end(), '\x02', '}');
  }
  return pieces;
}

/// Where the bracket that was opened before `at` is closed.
std::size_t EndOfCall(const std::string& code, std::size_t at) {
  bool in_text = false;
  for (int depth = 1; at < code.size() && depth > 0; ++at) {
    const char c = code[at];
    if (in_text && c == '\\') {
      ++at;
    } else if (c == '"') {
      in_text = !in_text;
    } else if (!in_text && (c == '(' || c == '{')) {
      ++depth;
    } else if (!in_text && (c == ')' || c == '}')) {
      --depth;
    }
  }
  return at;
}

std::vector<std::filesystem::path> Sources() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(FLEETPUB_SOURCE_DIR "/src")) {
    if (entry.is_regular_file() && entry.path().filename() != "embed.cc")
      files.push_back(entry.path());
  }
  return files;
}

TEST(TheTableOfMessages, HoldsEveryErrorWarningAndNote) {
  static const std::regex call(
      R"((\b(Fail|Warn|Tell|Note|PeopleLine)\(|\{ErrorKind::\w+,|\bError\{))");
  const std::string table = Replaced(
      SourceText("docs/messages.md") + SourceText("docs/robot-words.md"), std::regex("\n"), " ");
  std::size_t count = 0;
  for (const auto& file : Sources()) {
    const std::string code = CodeOf(file);
    for (std::sregex_iterator it(code.begin(), code.end(), call), end; it != end; ++it) {
      const auto begin = static_cast<std::size_t>(it->position() + it->length());
      for (const std::string& text : TextsIn(code.substr(begin, EndOfCall(code, begin) - begin))) {
        for (const std::string& piece : PiecesOfFormat(text)) {
          ++count;
          EXPECT_TRUE(table.find(piece) != std::string::npos || kNotInTheTable.contains(piece))
              << file << ": docs/messages.md does not have: " << piece;
        }
      }
    }
  }
  EXPECT_GT(count, 300U);
}

TEST(TheTableOfMessages, HoldsNothingElse) {
  std::string texts;
  for (const auto& file : Sources()) {
    for (const std::string& text : TextsIn(CodeOf(file))) texts += text + "\n";
  }
  texts =
      Replaced(Replaced(std::move(texts), std::regex(R"(\{\{)"), "{"), std::regex(R"(\}\})"), "}");
  std::istringstream rows(SourceText("docs/messages.md"));
  static const std::regex span(R"(``\s?(.*?)\s?``|`([^`]*)`)");
  std::size_t count = 0;
  for (std::string row; std::getline(rows, row);) {
    if (!row.starts_with("| `")) continue;
    const std::string messages = row.substr(2, row.find(" | ") - 2);
    for (std::sregex_iterator it(messages.begin(), messages.end(), span), end; it != end; ++it) {
      const std::string message = (*it)[1].matched ? (*it)[1] : (*it)[2];
      for (const std::string& piece : PiecesOf(message, std::regex("<[^>]*>|…"))) {
        ++count;
        EXPECT_NE(texts.find(piece), std::string::npos) << "nothing in src says: " << piece;
      }
    }
  }
  EXPECT_GT(count, 300U);
}

}  // namespace
}  // namespace fleetpub::testing
