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

using testing::AllOf;
using testing::AnyOf;
using testing::Contains;
using testing::EndsWith;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

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

TEST(OptionSet, AFlagMaySayMoreBehindAnEqualsSignOnly) {
  const auto parsed = [](const std::vector<std::string>& arguments) {
    OptionSet set(OptionSet::Extent::kMentioned, arguments);
    std::string when = "never";
    std::string target;
    set.AddFlag("--blink", Text(when), "always", "");
    set.AddOption("target", target, "");
    EXPECT_TRUE(set.Parse("lamp", arguments));
    return when + " " + target;
  };
  EXPECT_EQ(parsed({"KIT/1"}), "never KIT/1");
  EXPECT_EQ(parsed({"--blink", "KIT/1"}), "always KIT/1");
  EXPECT_EQ(parsed({"--blink=twice", "KIT/1"}), "twice KIT/1");
}

TEST(OptionSet, WordsAreAlwaysDeclared) {
  OptionSet set(OptionSet::Extent::kMentioned, {});
  std::string target;
  set.AddOption("target", target, "");
  ASSERT_TRUE(set.Parse("pause", {"KIT/0001"}));
  EXPECT_EQ(target, "KIT/0001");
}

TEST(OptionSet, SaysWhoGaveWhatAnOptionDoesNotTake) {
  const std::vector<std::string> flag = {"ping", "--keep-alive", "99999"};
  Declared by_flag(OptionSet::Extent::kMentioned, flag);
  const auto refused = by_flag.set.Parse("ping", {flag.begin() + 1, flag.end()});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::kUsage);
  EXPECT_THAT(refused.error().message, AllOf(HasSubstr("--keep-alive"), HasSubstr("99999")));

  const EnvironmentVariable variable("FLEETPUB_MQTT_VERSION", "4.0");
  Declared by_variable(OptionSet::Extent::kMentioned, {"ping"});
  const auto also_refused = by_variable.set.Parse("ping", {});
  ASSERT_FALSE(also_refused);
  EXPECT_THAT(also_refused.error().message, HasSubstr("FLEETPUB_MQTT_VERSION"));
}

TEST(OptionSet, OfSeveralValuesNamesTheOneThatIsRefused) {
  OptionSet set(OptionSet::Extent::kMentioned, {});
  std::vector<std::string> nodes;
  set.AddOption("nodes", Name(nodes), "").Type("NODE");
  const auto refused = set.Parse("order", {"n1", "", "n3"});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, EndsWith("not ''"));
}

TEST(OptionSet, ReadsTheConfigurationAsItReadsFlags) {
  Declared declared(OptionSet::Extent::kMentioned, {"ping"});
  ASSERT_TRUE(declared.set.Parse("ping", {}));
  config::Config config;
  config.settings["connect_timeout"].texts = {"250ms"};
  config.settings["insecure"].texts = {"true"};
  EXPECT_THAT(declared.set.Configure(config, {}).value(),
              UnorderedElementsAre("connect_timeout", "insecure"));
  EXPECT_EQ(declared.options.connect_timeout, std::chrono::milliseconds(250));
  EXPECT_TRUE(declared.options.insecure);
  config.settings["keep_alive"].texts = {"99999"};
  EXPECT_THAT(declared.set.Configure(config, {}).error().message, HasSubstr("keep_alive"));
}

// What the help names and completion offers is what the command line takes.
TEST(OptionSet, EveryChoiceIsTaken) {
  for (const Subcommand& subcommand : Subcommands()) {
    Declared all(OptionSet::Extent::kAll, {});
    static_cast<void>(subcommand.declare(all.set));
    for (const Option& option : all.set.options()) {
      for (const std::string_view choice : option.Choices({})) {
        if (option.IsPositional()) continue;
        Declared fresh(OptionSet::Extent::kAll, {});
        const cli::Run run = subcommand.declare(fresh.set);  // which holds what is stored
        const std::string name = "--" + option.long_names().front();
        EXPECT_TRUE(fresh.set.Parse("", {name + "=" + std::string(choice)}))
            << subcommand.name << " " << name << " " << choice;
      }
    }
  }
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
