// What holds for any input, tried with random ones. A failure prints the smallest counterexample
// and how to repeat it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cstdlib>
#include <map>

#include "app/batch_line.h"
#include "app/targets.h"
#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/options/target_options.h"
#include "cli/output/output.h"
#include "cli/parser/option_set.h"
#include "delivery/validate.h"
#include "ledger/ledger_support.h"
#include "mqtt/broker_url.h"
#include "vda5050/messages/instant_actions.h"
#include "vda5050/model/robot_address.h"
#include "vda5050/model/robot_pattern.h"

namespace fleetpub {
namespace {

rc::Gen<std::string> Bytes() { return rc::gen::arbitrary<std::string>(); }

// A name that may stand in a topic level: with letters of more than a byte, with all that means
// something to a reader of targets or to a shell, and with what nobody sees.
rc::Gen<std::string> LevelName() {
  const auto letter = rc::gen::element<std::string>(
      "a", "Z", "0", "2A", "_", ".", ":", "-", " ", "ü", "🤖", "*", "?", "@", "%", "[", "]", ",",
      "\\", "'", "\"", "`", ";", "=", "~", "!", "{", "}", "\u0085", "\u00A0", "\u202E", "\u3164");
  return rc::gen::map(
      rc::gen::nonEmpty(rc::gen::container<std::vector<std::string>>(letter)),
      [](const std::vector<std::string>& letters) { return base::Join(letters, ""); });
}

TEST(AnyRobotAddress, IsParsedFromItsText) {
  EXPECT_TRUE(rc::check([] {
    const vda5050::RobotAddress robot{*LevelName(), *LevelName()};
    const auto parsed = vda5050::ParseRobotAddress(robot.ToString());
    RC_ASSERT(parsed.has_value());
    RC_ASSERT(*parsed == robot);
  }));
}

// As an argument, as the value of an option and as a line, also when `xargs` cuts it at blanks.
TEST(AnyRobotAddress, MeansThatRobotAloneWhereverItIsReadBack) {
  EXPECT_TRUE(rc::check([] {
    const vda5050::RobotAddress robot{*LevelName(), *LevelName()};
    const std::string word = robot.ToString();
    RC_ASSERT(base::Trimmed(word) == word);
    RC_ASSERT(base::Printable(word) == word);
    RC_ASSERT(word.find_first_of("\\\"'") == std::string::npos);
    for (const std::string& piece : base::Split(word, ' ')) {
      RC_ASSERT(piece.empty() || (piece.front() != '-' && piece.front() != '@'));
    }
    const std::vector<std::string> arguments = {"--except", word, word};
    cli::OptionSet set(cli::OptionSet::Extent::kMentioned, arguments);
    cli::TargetOptions options;
    cli::DeclareTargetOptions(set, options);
    RC_ASSERT(set.Parse("pause", arguments) == cli::OptionSet::Asked::kRun);
    RC_ASSERT(options.words == std::vector{word});
    cli::Output output({.quiet = true});
    const auto read = app::ParseTargetSpec(options.words, config::Config(), output);
    RC_ASSERT(read.has_value());
    RC_ASSERT(read->patterns.empty() && read->set.empty());
    RC_ASSERT(read->robots == std::vector{robot});
    const auto in_batch = app::AsWritten(word);
    RC_ASSERT(in_batch.has_value() && in_batch->robot == robot);
  }));
}

TEST(AnyText, IsRefusedAsATargetOrNamesTwoLevels) {
  EXPECT_TRUE(rc::check([] {
    const std::string text = *Bytes();
    const auto robot = vda5050::ParseRobotAddress(text);
    if (!robot) return;
    RC_ASSERT(vda5050::ParseRobotAddress(robot->ToString()) == *robot);
    RC_ASSERT(text.find_first_of("+#$") == std::string::npos);
    RC_ASSERT(base::Split(text, '/').size() == 2U);
  }));
}

TEST(AnyRobotAddress, MatchesItselfAsAPattern) {
  EXPECT_TRUE(rc::check([] {
    const vda5050::RobotAddress robot{*LevelName(), *LevelName()};
    const auto pattern = vda5050::ParseRobotPattern(robot.ToString());
    RC_ASSERT(pattern.has_value());
    RC_ASSERT(pattern->Matches(robot));
  }));
}

TEST(AnyBrokerUrl, IsParsedFromItsText) {
  EXPECT_TRUE(rc::check([] {
    const auto word = rc::gen::nonEmpty(
        rc::gen::container<std::string>(rc::gen::elementOf(std::string("abz019-._"))));
    const auto login = rc::gen::nonEmpty(rc::gen::container<std::string>(
        rc::gen::elementOf(std::string("aZ0 %/?#[]@:\"&=+,;~!$'()*<>^`{|}"))));
    mqtt::BrokerUrl url;
    url.scheme = *rc::gen::element(mqtt::Scheme::kMqtt, mqtt::Scheme::kMqtts, mqtt::Scheme::kWs,
                                   mqtt::Scheme::kWss);
    url.host = *rc::gen::oneOf(word, rc::gen::element<std::string>("::1", "fe80::1", "10.0.0.1"));
    url.port = *rc::gen::inRange<std::uint16_t>(1, 65'535);
    url.username = *login;
    if (url.UsesWebSocket()) url.path = "/" + *word;
    std::string escaped;
    for (const char c : url.username) escaped += fmt::format("%{:02x}", c);
    std::string text = url.ToString();  // never names the user
    text.insert(text.find("://") + 3, escaped + "@");
    const auto parsed = mqtt::ParseBrokerUrl(text);
    if (!parsed) RC_FAIL(text + ": " + parsed.error().message);
    const bool same = *parsed == url;
    RC_ASSERT(same);
    RC_ASSERT(parsed->ToString() == url.ToString());
  }));
}

vda5050::Parameter MakeAnyValue(const vda5050::ParameterSpec& spec) {
  std::string text = *LevelName();
  if (spec.type == vda5050::ParameterType::kLength) {
    text = std::to_string(*rc::gen::inRange(-1'000'000, 1'000'000)) + ".5e-3";
  } else if (spec.type == vda5050::ParameterType::kAngle) {
    text = std::to_string(*rc::gen::inRange(-3'141, 3'142)) + "e-3";
  }
  const auto parameter = vda5050::ParseParameter(spec, text);
  RC_ASSERT(parameter.has_value());
  return *parameter;
}

// Of every version's every instant action, with any of its parameters: what is built is valid.
TEST(AnyInstantAction, IsValidOnceItIsBuilt) {
  schema::Registry registry;
  for (const vda5050::Version version : vda5050::kVersions) {
    auto actions = vda5050::ListActions(version);
    std::erase_if(actions, [](const auto* spec) { return !spec->scopes.instant; });
    std::size_t turn = 0;  // each action several times
    EXPECT_TRUE(rc::check([&] {
      const vda5050::ActionSpec& spec = *actions[turn++ % actions.size()];
      vda5050::InstantAction action{.type = std::string(spec.type), .id = *LevelName()};
      action.descriptor = *rc::gen::oneOf(LevelName(), rc::gen::just(std::string()));
      for (const vda5050::ParameterSpec& parameter : spec.parameters) {
        if (parameter.required || *rc::gen::arbitrary<bool>()) {
          action.parameters.push_back(MakeAnyValue(parameter));
        }
      }
      const auto command = vda5050::BuildInstantActions({*LevelName(), *LevelName()},
                                                        {.version = version}, {{action}});
      if (!command) RC_FAIL(command.error().message);
      const auto findings = delivery::Validate(*command, registry);
      if (!findings) RC_FAIL(findings.error().message);
      if (!findings->errors.empty()) RC_FAIL(delivery::Describe(*findings));
    }));
  }
}

// Whatever is asked for, by whomever opens the ledger anew: per topic ids only rise.
TEST(AnyHeaderIds, RisePerTopic) {
  const fleetpub::testing::TemporaryFolder folder;
  auto ledger = ledger::MustOpen(folder / "ledger.db");
  int first_robot = 0;
  EXPECT_TRUE(rc::check([&] {
    std::map<int, std::optional<std::uint32_t>> last;
    first_robot += 3;
    const auto wishes = *rc::gen::container<std::vector<std::pair<int, std::uint32_t>>>(
        12, rc::gen::pair(rc::gen::inRange(0, 3), rc::gen::inRange<std::uint32_t>(0, 60)));
    for (const auto& [robot, wish] : wishes) {
      if (wish % 7 == 0) ledger = ledger::MustOpen(folder / "ledger.db");
      ledger::Draft draft = ledger::DraftFor(first_robot + robot);
      if (wish % 2 == 0) draft.header_id = wish;
      const auto reserved = ledger->Reserve(std::span(&draft, 1));
      const bool is_late = draft.header_id && last[robot] && *draft.header_id <= *last[robot];
      RC_ASSERT(reserved.has_value() == !is_late);
      if (!reserved) continue;
      const std::uint32_t id = reserved->front().header_id;
      RC_ASSERT(!last[robot] || id > *last[robot]);
      RC_ASSERT(id == draft.header_id.value_or(last[robot] ? *last[robot] + 1 : 0));
      last[robot] = id;
    }
  }));
}

// Arrays, objects and all that can stand in them, to a small depth.
std::string AnyJson(int depth) {
  const int kind = *rc::gen::inRange(0, depth > 0 ? 7 : 5);
  if (kind == 0) return *rc::gen::element<std::string>("null", "true", "false");
  if (kind == 1) return base::JsonString(*LevelName());
  if (kind == 2) return std::to_string(*rc::gen::arbitrary<std::int64_t>());
  if (kind == 3) return std::to_string(*rc::gen::arbitrary<std::uint64_t>());
  if (kind == 4) return fmt::format("{}", *rc::gen::inRange(-999'999, 999'999) / 1'024.0);
  std::vector<std::string> parts;
  const int count = *rc::gen::inRange(0, 4);
  for (int i = 0; i < count; ++i) {
    const std::string name = base::JsonString(std::to_string(i) + *LevelName());
    parts.push_back((kind == 5 ? "" : name + ":") + AnyJson(depth - 1));
  }
  const std::string inside = base::Join(parts, ",");
  return kind == 5 ? "[" + inside + "]" : "{" + inside + "}";
}

TEST(AnyNumber, IsReadAsTheNearestDouble) {
  EXPECT_TRUE(rc::check([] {
    const auto digits = rc::gen::container<std::string>(rc::gen::elementOf(std::string("000019")));
    std::string text = *rc::gen::element<std::string>("", "-");
    text += *rc::gen::element<std::string>("0", "1", "9007199254740993", "123456789012345678");
    text += "." + *digits + "0e" + std::to_string(*rc::gen::inRange(-400, 280));
    const auto document = base::ParseJson(text);
    if (!document) RC_FAIL(text + ": " + document.error().message);
    RC_ASSERT(document->GetDouble() == std::strtod(text.c_str(), nullptr));
  }));
}

TEST(AnyJson, ComesBackFromItsText) {
  EXPECT_TRUE(rc::check([] {
    const std::string text = AnyJson(3);
    const auto document = base::ParseJson(text);
    if (!document) RC_FAIL(text + ": " + document.error().message);
    const std::string printed = base::ToJson(*document);
    const auto again = base::ParseJson(printed);
    RC_ASSERT(again.has_value());
    const bool same = *again == *document;
    RC_ASSERT(same);
    RC_ASSERT(base::ToJson(*again) == printed);
    const auto pretty = base::ParseJson(base::ToPrettyJson(*document));
    RC_ASSERT(pretty.has_value());
    RC_ASSERT(base::ToJson(*pretty) == printed);
  }));
}

TEST(AnyText, ComesBackFromAJsonString) {
  EXPECT_TRUE(rc::check([] {
    const std::string text = *LevelName() + base::Printable(*Bytes());
    const auto parsed = base::ParseJson(base::JsonString(text));
    RC_ASSERT(parsed.has_value());
    RC_ASSERT(base::ToView(*parsed) == text);
  }));
}

TEST(AnyText, IsPrintedSafely) {
  EXPECT_TRUE(rc::check([] {
    const std::string shown = base::Printable(*Bytes());
    RC_ASSERT(base::IsUtf8(shown));
    RC_ASSERT(base::Printable(shown) == shown);
  }));
}

TEST(AnyText, IsParsedAsJsonOrRefusedWithASentence) {
  EXPECT_TRUE(rc::check([] {
    const auto letters = *rc::gen::container<std::string>(
        rc::gen::elementOf(std::string("[]{}\",:\\u0eE+-.d8 \n\xC3\xED\xA0")));
    const auto document = base::ParseJson(letters);
    if (!document) {
      RC_ASSERT(!document.error().message.empty());
      return;
    }
    const std::string text = base::ToJson(*document);
    RC_ASSERT(base::IsUtf8(text));
    RC_ASSERT(base::ParseJson(text).has_value());
  }));
}

TEST(AnyName, IsFoundByItsPointerToken) {
  EXPECT_TRUE(rc::check([] {
    const std::string name =
        *rc::gen::container<std::string>(rc::gen::elementOf(std::string("ab~/01")));
    base::JsonDocument document(rapidjson::kObjectType);
    base::JsonValue key(name, document.GetAllocator());
    document.AddMember(key, base::JsonValue(42), document.GetAllocator());
    const std::string text = "/" + base::PointerToken(name);
    const base::JsonPointer pointer(text.c_str(), text.size());
    RC_ASSERT(pointer.IsValid());
    const base::JsonValue* found = pointer.Get(document);
    RC_ASSERT(found != nullptr && found->GetInt() == 42);
  }));
}

TEST(AnyMillisecond, ComesBackFromItsTimestamp) {
  EXPECT_TRUE(rc::check([] {
    constexpr std::int64_t kFirst = -2'208'988'800'000;  // 1900
    constexpr std::int64_t kLast = 6'942'758'400'000;    // 2190
    const base::WallTime time{std::chrono::milliseconds(*rc::gen::inRange(kFirst, kLast))};
    const std::string text = base::FormatTimestamp(time);
    RC_ASSERT(text.size() == 24U);
    RC_ASSERT(base::ParseDateTime(text) == time);
  }));
}

TEST(AnyTwoWords, AreAsFarFromEachOtherEitherWay) {
  EXPECT_TRUE(rc::check([] {
    const auto word = rc::gen::container<std::string>(rc::gen::elementOf(std::string("abAB")));
    const std::string a = *word;
    const std::string b = *word;
    const int distance = base::EditDistance(a, b);
    RC_ASSERT(distance == base::EditDistance(b, a));
    RC_ASSERT((distance == 0) == base::EqualsIgnoringCase(a, b));
    RC_ASSERT(distance <= static_cast<int>(std::max(a.size(), b.size())));
  }));
}

}  // namespace
}  // namespace fleetpub
