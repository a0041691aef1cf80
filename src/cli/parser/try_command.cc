#include "cli/parser/try_command.h"

#include <algorithm>

#include "base/text.h"

namespace fleetpub::cli {
namespace {

// -P and --password hold one where other programs are meant.
bool MayBeRepeated(const std::string& argument) {
  return !argument.starts_with("-P") && !base::ToLower(argument).starts_with("--pass") &&
         base::Printable(argument) == argument;
}

std::string Quoted(const std::string& word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_@%+=:,./-";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  return "'" + base::Join(base::Split(word, '\''), R"('\'')") + "'";
}

}  // namespace

std::string TryCommand(std::string_view command, std::span<const std::string> arguments) {
  std::string text = "try: fleetpub " + std::string(command);
  if (!std::all_of(arguments.begin(), arguments.end(), MayBeRepeated)) return text + " -h";
  for (const std::string& argument : arguments) text += " " + Quoted(argument);
  return text;
}

std::string ShellLine(std::span<const std::string> words) {
  std::string line;
  for (const std::string& word : words) {
    if (base::Printable(word) != word) return "";
    line += (line.empty() ? "" : " ") + Quoted(word);
  }
  return line;
}

}  // namespace fleetpub::cli
