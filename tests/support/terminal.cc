#include "support/terminal.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace fleetpub::testing {

Terminal::Terminal(const std::string& line, int columns, int rows) {
  Tmux({"new-session", "-d", "-x", std::to_string(columns), "-y", std::to_string(rows), line});
}

Terminal::~Terminal() { Tmux({"kill-server"}); }

void Terminal::Press(const std::string& key) { Tmux({"send-keys", key}); }

void Terminal::Type(const std::string& text) { Tmux({"send-keys", "-l", "--", text}); }

void Terminal::Resize(int columns, int rows) {
  Tmux({"resize-window", "-x", std::to_string(columns), "-y", std::to_string(rows)});
}

std::string Terminal::Shown() { return Tmux({"capture-pane", "-p"}); }

std::string Terminal::ShownInColour() { return Tmux({"capture-pane", "-p", "-e"}); }

std::size_t Terminal::MeasureWidth(const std::string& text) {
  Tmux({"set-option", "-g", "@text", text});
  return std::stoul(Tmux({"display-message", "-p", "#{w:@text}"}));
}

std::string Terminal::Flags() {
  return Tmux({"display-message", "-p", "#{alternate_on} #{cursor_flag}"});
}

bool Terminal::Await(const std::string& text) {
  const auto deadline = std::chrono::steady_clock::now() + Process::kPatience;
  while (std::chrono::steady_clock::now() < deadline) {
    if (Shown().find(text) != std::string::npos) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ADD_FAILURE() << "no '" << text << "' in:\n" << Shown();
  return false;
}

std::string Terminal::Tmux(std::vector<std::string> arguments) {
  const std::vector<std::string> server = {"tmux", "-S", folder_ / "tmux", "-f", "/dev/null"};
  arguments.insert(arguments.begin(), server.begin(), server.end());
  return Run({.arguments = std::move(arguments), .environment = {{"TERM", "xterm"}}}).output;
}

std::string ShellLine(const Command& command) {
  std::string line = "env -u NO_COLOR";
  for (const auto& [name, value] : command.environment) {
    if (value) line += " " + name + "='" + *value + "'";
  }
  for (const std::string& argument : command.arguments) line += " '" + argument + "'";
  return line;
}

}  // namespace fleetpub::testing
