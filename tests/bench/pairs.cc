// Times whole processes in turn: A B C A B C …, so that all meet the same machine.
//
//   pairs RUNS FIGURE CSV  NAME A…  --  NAME B…  [--  NAME C… …]
//
// Prints the medians of wall time, the largest peak of memory, and the median of the ratios A/B
// turn by turn; of more than two commands a table with A's ratio to each. Appends a line per run to
// CSV: figure,program,run,milliseconds,processor_milliseconds,kilobytes. Commands are given no
// shell, /dev/null for their output, and no input unless the first word behind NAME is `<FILE`.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

struct Cost {
  double milliseconds = 0;
  double processor = 0;  // user and system, milliseconds
  double megabytes = 0;
};

struct Program {
  std::string name;
  std::string input = "/dev/null";
  std::vector<char*> command;
  std::vector<Cost> costs = {};
};

double Milliseconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_usec) / 1e3;
}

Cost RunOnce(const Program& program) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, program.input.c_str(), O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  const auto start = std::chrono::steady_clock::now();
  pid_t pid = 0;
  if (posix_spawnp(&pid, program.command[0], &actions, nullptr, program.command.data(), environ) !=
      0) {
    fmt::print(stderr, "pairs: cannot start {}\n", program.command[0]);
    std::exit(2);
  }
  int status = 0;
  rusage usage{};
  wait4(pid, &status, 0, &usage);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  posix_spawn_file_actions_destroy(&actions);
  if (status != 0) {
    fmt::print(stderr, "pairs: {} failed with status {:#x}\n", program.name, status);
    std::exit(1);
  }
  return {took.count(), Milliseconds(usage.ru_utime) + Milliseconds(usage.ru_stime),
          static_cast<double>(usage.ru_maxrss) / 1024};
}

double Quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

std::vector<double> Times(const Program& program) {
  std::vector<double> times;
  for (const Cost& cost : program.costs) times.push_back(cost.milliseconds);
  return times;
}

double Peak(const Program& program) {
  double peak = 0;
  for (const Cost& cost : program.costs) peak = std::max(peak, cost.megabytes);
  return peak;
}

// The median of the ratios turn by turn.
double Ratio(const Program& a, const Program& b) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < a.costs.size(); ++i) {
    ratios.push_back(a.costs[i].milliseconds / b.costs[i].milliseconds);
  }
  return Quantile(ratios, 0.5);
}

void Print(const std::string& figure, const std::vector<Program>& programs) {
  if (programs.size() == 2) {
    fmt::print("{:<44} {:>7.2f} ms {:>7.2f} ms   ratio {:.2f}   peak {:.1f} MB, {:.1f} MB\n",
               figure, Quantile(Times(programs[0]), 0.5), Quantile(Times(programs[1]), 0.5),
               Ratio(programs[0], programs[1]), Peak(programs[0]), Peak(programs[1]));
    return;
  }
  fmt::print("{:<44} {:>8} {:>8} {:>8} {:>8} {:>9}\n", figure, "p50 ms", "p90", "p99", "ratio",
             "peak MB");
  for (const Program& program : programs) {
    const auto times = Times(program);
    fmt::print("{:<44} {:>8.2f} {:>8.2f} {:>8.2f} {:>8.2f} {:>9.1f}\n", "  " + program.name,
               Quantile(times, 0.5), Quantile(times, 0.9), Quantile(times, 0.99),
               Ratio(programs[0], program), Peak(program));
  }
}

void Append(const char* file, const std::string& figure, const std::vector<Program>& programs) {
  std::FILE* csv = std::fopen(file, "a");
  if (csv == nullptr) {
    fmt::print(stderr, "pairs: cannot write {}\n", file);
    std::exit(2);
  }
  if (std::ftell(csv) == 0) {
    fmt::print(csv, "figure,program,run,milliseconds,processor_milliseconds,kilobytes\n");
  }
  for (const Program& program : programs) {
    for (std::size_t run = 0; run < program.costs.size(); ++run) {
      const Cost& cost = program.costs[run];
      fmt::print(csv, "\"{}\",\"{}\",{},{:.3f},{:.3f},{:.0f}\n", figure, program.name, run,
                 cost.milliseconds, cost.processor, cost.megabytes * 1024);
    }
  }
  std::fclose(csv);
}

std::vector<Program> ParsePrograms(int argc, char** argv) {
  std::vector<Program> programs;
  for (int i = 4; i < argc; ++i) {
    const std::string word = argv[i];
    if (i == 4 || word == "--") {
      if (word == "--") ++i;
      if (i < argc) programs.push_back({.name = argv[i]});
    } else if (word.starts_with('<') && programs.back().command.empty()) {
      programs.back().input = word.substr(1);
    } else {
      programs.back().command.push_back(argv[i]);
    }
  }
  for (Program& program : programs) {
    if (program.command.empty()) return {};
    program.command.push_back(nullptr);
  }
  return programs;
}

}  // namespace

int main(int argc, char** argv) {
  auto programs = ParsePrograms(argc, argv);
  if (programs.size() < 2) {
    fmt::print(stderr, "usage: pairs RUNS FIGURE CSV NAME A... -- NAME B... [-- NAME C... ...]\n");
    return 2;
  }
  const int runs = std::max(1, std::atoi(argv[1]));
  const int warm_up = runs < 20 ? 1 : 5;
  for (int i = 0; i < runs + warm_up; ++i) {
    for (Program& program : programs) {
      const Cost cost = RunOnce(program);
      if (i >= warm_up) program.costs.push_back(cost);
    }
  }
  Print(argv[2], programs);
  Append(argv[3], argv[2], programs);
  return 0;
}
