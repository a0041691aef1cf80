#include "cli/option_set.h"

#include <gmock/gmock.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <vector>

#include "base/text.h"
#include "cli/global_options.h"
#include "cli/subcommand.h"

namespace fleetpub::cli {
namespace {

using testing::AnyOf;
using testing::Contains;

struct Declared {
  CLI::App app;
  GlobalOptions options;

  Declared(OptionSet::Extent extent, const std::vector<std::string>& arguments) {
    OptionSet set(app, extent, arguments);
    DeclareGlobalOptions(set, options);
  }

  [[nodiscard]] bool Has(const std::string& name) const {
    return app.get_option_no_throw(name) != nullptr;
  }
};

class EnvironmentVariable {
 public:
  EnvironmentVariable(const char* name, const char* value) : name_(name) {
    setenv(name, value, 1);  // NOLINT(concurrency-mt-unsafe): tests run in one thread
  }
  EnvironmentVariable(const EnvironmentVariable&) = delete;
  EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;
  ~EnvironmentVariable() { unsetenv(name_); }  // NOLINT(concurrency-mt-unsafe)

 private:
  const char* name_;
};

TEST(OptionSet, DeclaresWhatTheArgumentsMention) {
  const Declared some(OptionSet::Extent::kMentioned, {"pause", "--ledger=a.db", "-vb", "mqtt://h"});
  EXPECT_TRUE(some.Has("--ledger"));
  EXPECT_TRUE(some.Has("--broker"));
  EXPECT_TRUE(some.Has("--verbose"));
  EXPECT_FALSE(some.Has("--cafile"));
  EXPECT_FALSE(some.Has("--port"));
}

TEST(OptionSet, DeclaresWhatTheEnvironmentSets) {
  const EnvironmentVariable file("FLEETPUB_PASSWORD_FILE", "/tmp/pw");
  const Declared some(OptionSet::Extent::kMentioned, {"pause"});
  EXPECT_TRUE(some.Has("--password-file"));
  EXPECT_FALSE(some.Has("--cafile"));
}

TEST(OptionSet, DeclaresEverythingForWhoNeedsTheList) {
  const Declared all(OptionSet::Extent::kAll, {});
  EXPECT_TRUE(all.Has("--cafile"));
  EXPECT_TRUE(all.Has("--no-history"));
}

TEST(OptionSet, WhatIsLeftOutKeepsItsValueAndIsEmpty) {
  CLI::App app;
  OptionSet set(app, OptionSet::Extent::kMentioned, {});
  std::string value = "before";
  const CLI::Option* option = set.AddOption("--colour", value, "")->type_name("NAME")->group("G");
  app.parse(std::vector<std::string>());
  EXPECT_TRUE(option->empty());
  EXPECT_EQ(value, "before");
}

TEST(OptionSet, WordsAreAlwaysDeclared) {
  CLI::App app;
  OptionSet set(app, OptionSet::Extent::kMentioned, {});
  std::string target;
  set.AddOption("target", target, "");
  app.parse(std::vector<std::string>{"KIT/0001"});
  EXPECT_EQ(target, "KIT/0001");
}

// An option whose variable were called otherwise would not be found by it.
TEST(OptionSet, EveryVariableIsNamedAfterItsOption) {
  for (const Subcommand& subcommand : Subcommands()) {
    CLI::App app;
    GlobalOptions options;
    OptionSet set(app, OptionSet::Extent::kAll, {});
    DeclareGlobalOptions(set, options);
    static_cast<void>(subcommand.declare(set));
    for (const CLI::Option* option : app.get_options()) {
      if (option->get_envname().empty()) continue;
      std::string name = base::ToLower(option->get_envname().substr(9));
      std::replace(name.begin(), name.end(), '_', '-');
      const std::string behind_a_word = name.substr(name.find('-') + 1);
      EXPECT_THAT(option->get_lnames(), AnyOf(Contains(name), Contains(behind_a_word)))
          << subcommand.name;
    }
  }
}

}  // namespace
}  // namespace fleetpub::cli
