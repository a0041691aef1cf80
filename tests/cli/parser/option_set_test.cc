#include "cli/parser/option_set.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "base/text.h"
#include "cli/options/global_options.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

using testing::AnyOf;
using testing::Contains;

struct Declared {
  GlobalOptions options;
  OptionSet set;

  Declared(OptionSet::Extent extent, const std::vector<std::string>& arguments)
      : set(extent, arguments) {
    DeclareGlobalOptions(set, options);
  }

  [[nodiscard]] bool Has(const std::string& name) const { return set.IsDeclared(name); }
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
  OptionSet set(OptionSet::Extent::kMentioned, {});
  std::string value = "before";
  const Option option = set.AddOption("--colour", value, "").Type("NAME").Group("G");
  ASSERT_TRUE(set.Parse("pause", {}));
  EXPECT_TRUE(!option.IsGiven());
  EXPECT_EQ(value, "before");
}

TEST(OptionSet, WordsAreAlwaysDeclared) {
  OptionSet set(OptionSet::Extent::kMentioned, {});
  std::string target;
  set.AddOption("target", target, "");
  ASSERT_TRUE(set.Parse("pause", {"KIT/0001"}));
  EXPECT_EQ(target, "KIT/0001");
}

// An option whose variable were called otherwise would not be found by it.
TEST(OptionSet, EveryVariableIsNamedAfterItsOption) {
  for (const Subcommand& subcommand : Subcommands()) {
    GlobalOptions options;
    OptionSet set(OptionSet::Extent::kAll, {});
    DeclareGlobalOptions(set, options);
    static_cast<void>(subcommand.declare(set));
    for (const Option& option : set.options()) {
      if (option.variable().empty()) continue;
      std::string name = base::ToLower(option.variable().substr(9));
      std::replace(name.begin(), name.end(), '_', '-');
      const std::string behind_a_word = name.substr(name.find('-') + 1);
      EXPECT_THAT(option.long_names(), AnyOf(Contains(name), Contains(behind_a_word)))
          << subcommand.name;
    }
  }
}

}  // namespace
}  // namespace fleetpub::cli
