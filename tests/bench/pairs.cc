// Times whole processes in pairs: A B A B …, so that both meet the same machine.
//
//   pairs RUNS LABEL  A…  --  B…
//
// Prints the medians of wall time and peak memory of each, and the median of the ratios A/B pair by
// pair. Both commands are given no shell, no input, and /dev/null for their output.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

struct Cost {
  double milliseconds = 0;
  long kilobytes = 0;
};

Cost RunOnce(const std::vector<char*>& command) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  const auto start = std::chrono::steady_clock::now();
  pid_t pid = 0;
  if (posix_spawnp(&pid, command[0], &actions, nullptr, command.data(), environ) != 0) {
    fmt::print(stderr, "pairs: cannot start {}\n", command[0]);
    std::exit(2);
  }
  int status = 0;
  rusage usage{};
  wait4(pid, &status, 0, &usage);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  posix_spawn_file_actions_destroy(&actions);
  if (status != 0) {
    fmt::print(stderr, "pairs: {} failed with status {:#x}\n", command[0], status);
    std::exit(1);
  }
  return {took.count(), usage.ru_maxrss};
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::vector<char*>> commands(1);
  for (int i = 3; i < argc; ++i) {
    if (std::string(argv[i]) == "--") {
      commands.emplace_back();
    } else {
      commands.back().push_back(argv[i]);
    }
  }
  if (argc < 6 || commands.size() != 2 || commands[0].empty() || commands[1].empty()) {
    fmt::print(stderr, "usage: pairs RUNS LABEL A... -- B...\n");
    return 2;
  }
  for (auto& command : commands) command.push_back(nullptr);
  const int runs = std::max(1, std::atoi(argv[1]));
  constexpr int kWarmUp = 5;
  std::vector<double> a;
  std::vector<double> b;
  std::vector<double> ratios;
  long memory_a = 0;
  long memory_b = 0;
  for (int i = 0; i < runs + kWarmUp; ++i) {
    const Cost first = RunOnce(commands[0]);
    const Cost second = RunOnce(commands[1]);
    if (i < kWarmUp) continue;
    a.push_back(first.milliseconds);
    b.push_back(second.milliseconds);
    ratios.push_back(first.milliseconds / second.milliseconds);
    memory_a = std::max(memory_a, first.kilobytes);
    memory_b = std::max(memory_b, second.kilobytes);
  }
  fmt::print("{:<44} {:>7.2f} ms {:>7.2f} ms   ratio {:.2f}   peak {:.1f} MB, {:.1f} MB\n", argv[2],
             Median(a), Median(b), Median(ratios), static_cast<double>(memory_a) / 1024,
             static_cast<double>(memory_b) / 1024);
  return 0;
}
