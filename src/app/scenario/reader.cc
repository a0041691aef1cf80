// Strictly: a misspelt key would be a check that silently is not made.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <span>

#include "app/scenario/scenario.h"
#include "app/targets.h"
#include "base/text.h"
#include "base/time.h"
#include "config/toml_text.h"
#include "message/command_status.h"
#include "vda5050/reports/condition.h"

namespace fleetpub::app::scenario {
namespace {

using config::TomlMember;
using config::TomlPlace;
using config::TomlValue;
using std::chrono::milliseconds;
using Type = TomlValue::Type;

constexpr milliseconds kUsualLimit = std::chrono::seconds(10);

struct Kind {
  std::string_view name;
  StepKind kind;
  std::string_view example;
  std::vector<std::string_view> keys;  ///< besides its own, and within
};

const std::vector<Kind>& Kinds() {
  static const std::vector<Kind> kKinds = {
      {"simulate", StepKind::kSimulate, R"(simulate = "KIT/0001 --vda 2.1")", {}},
      {"send", StepKind::kSend, R"(send = "pause KIT/0001 --wait")", {"outcome", "payload"}},
      {"expect", StepKind::kExpect, R"(expect = "paused=true")", {"robot", "topic", "for"}},
      {"await", StepKind::kAwait, R"(await = "paused=true")", {"robot", "topic"}},
      {"capture",
       StepKind::kCapture,
       R"(capture = "orderId", as = "order")",
       {"as", "robot", "topic"}},
  };
  return kKinds;
}

bool IsName(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return c == '_' || c == '-' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
           (c >= 'A' && c <= 'Z');
  });
}

const TomlMember* Find(const TomlValue& table, std::string_view name) {
  const auto found = std::find_if(table.members.begin(), table.members.end(),
                                  [&](const TomlMember& member) { return member.name == name; });
  return found == table.members.end() ? nullptr : &*found;
}

class Reader {
 public:
  Reader(const std::string& file, const config::Config& config, const CommandCheck& check,
         config::Mistakes& mistakes)
      : file_(file), config_(config), check_(check), mistakes_(mistakes) {}

  std::vector<Test> Read(const TomlValue& document) {
    CheckKeys(document, std::vector<std::string_view>{"within", "test"}, "a file");
    limit_ = ReadDuration(document, "within", kUsualLimit);
    std::vector<Test> tests;
    const TomlMember* list = Find(document, "test");
    if (list == nullptr || list->value.type != Type::kArray || list->value.items.empty()) {
      Refuse(list == nullptr ? TomlPlace{1, 1} : list->place,
             R"(a file has tests: write [[test]], and below it name = "..." and steps = [...])");
      return tests;
    }
    std::set<std::string> names;
    for (const TomlValue& item : list->value.items) {
      tests.push_back(ReadTest(item));
      if (!tests.back().name.empty() && !names.insert(tests.back().name).second) {
        Refuse(item.place, fmt::format("name: another test is called {}, too",
                                       base::Printable(tests.back().name)));
      }
    }
    return tests;
  }

 private:
  void Refuse(TomlPlace place, std::string_view why) {
    mistakes_.push_back(config::ErrorAt({file_, place.line, place.column}, why));
  }

  void CheckKeys(const TomlValue& table, std::span<const std::string_view> known,
                 std::string_view of) {
    for (const TomlMember& member : table.members) {
      if (std::find(known.begin(), known.end(), member.name) != known.end()) continue;
      const auto nearest = base::Nearest(member.name, known);
      Refuse(member.place,
             fmt::format("{}: there is no such key{}", base::Printable(member.name),
                         nearest ? fmt::format(": did you mean {}?", *nearest)
                                 : fmt::format("; {} has {}", of, fmt::join(known, ", "))));
    }
  }

  // "": there is none, or it is none.
  std::string ReadText(const TomlValue& table, std::string_view key) {
    const TomlMember* member = Find(table, key);
    if (member == nullptr) return {};
    if (member->value.type == Type::kText && !base::Trimmed(member->value.text).empty()) {
      return member->value.text;
    }
    Refuse(member->place, fmt::format("{0} takes a text: {0} = \"...\"", key));
    return {};
  }

  // One text, or a list of them.
  std::vector<std::string> ReadTexts(const TomlMember& member) {
    std::vector<std::string> texts;
    const TomlValue& value = member.value;
    if (value.type == Type::kText) texts.push_back(value.text);
    for (const TomlValue& item : value.items) {
      if (item.type == Type::kText) texts.push_back(item.text);
    }
    const bool is_list = value.type == Type::kArray && texts.size() == value.items.size();
    const bool is_there = !texts.empty() && !base::Trimmed(texts.front()).empty();
    if (is_there && (value.type == Type::kText || is_list)) {
      return texts;
    }
    Refuse(member.place, fmt::format("{0} takes a text, or a list of texts: {0} = \"...\"",
                                     base::Printable(member.name)));
    return {};
  }

  milliseconds ReadDuration(const TomlValue& table, std::string_view key, milliseconds usual) {
    const TomlMember* member = Find(table, key);
    if (member == nullptr) return usual;
    const auto time = member->value.type == Type::kText ? base::ParseDuration(member->value.text)
                                                        : Fail(ErrorKind::kUsage, "");
    if (time && time->count() > 0) return *time;
    Refuse(member->place, fmt::format("{0} takes a time, such as {0} = \"5s\"", key));
    return usual;
  }

  Test ReadTest(const TomlValue& table) {
    Test test{.line = table.place.line};
    if (table.type != Type::kTable) {
      Refuse(table.place, "a test is a table: write [[test]]");
      return test;
    }
    CheckKeys(table, std::vector<std::string_view>{"name", "robot", "skip", "steps"}, "a test");
    test.name = ReadText(table, "name");
    test.skip = ReadText(table, "skip");
    if (Find(table, "name") == nullptr) {
      Refuse(table.place, R"(a test has a name: name = "a pause is obeyed")");
    }
    robot_ = ReadRobot(table);
    captured_.clear();
    const TomlMember* steps = Find(table, "steps");
    if (steps == nullptr || steps->value.type != Type::kArray || steps->value.items.empty()) {
      Refuse(steps == nullptr ? table.place : steps->place,
             fmt::format("a test has steps: steps = [ {{ {} }} ]", Kinds()[1].example));
      return test;
    }
    for (const TomlValue& item : steps->value.items) {
      if (auto step = ReadStep(item)) test.steps.push_back(*std::move(step));
    }
    return test;
  }

  std::optional<vda5050::RobotAddress> ReadRobot(const TomlValue& table) {
    const std::string word = ReadText(table, "robot");
    if (word.empty()) return std::nullopt;
    auto robot = ResolveRobot(word, config_);
    if (robot) return *std::move(robot);
    Refuse(Find(table, "robot")->place, "robot: " + robot.error().message);
    return std::nullopt;
  }

  std::optional<Step> ReadStep(const TomlValue& table) {
    const Kind* kind = nullptr;
    const TomlMember* own = nullptr;
    for (const Kind& candidate : Kinds()) {
      const TomlMember* member = Find(table, candidate.name);
      if (member == nullptr) continue;
      if (kind != nullptr) {
        Refuse(member->place, fmt::format("a step is one thing, not {} and {}: write two steps",
                                          kind->name, candidate.name));
        return std::nullopt;
      }
      kind = &candidate;
      own = member;
    }
    if (kind == nullptr) {
      std::vector<std::string_view> names;
      names.reserve(Kinds().size());
      for (const Kind& candidate : Kinds()) names.push_back(candidate.name);
      for (const TomlMember& member : table.members) {
        if (const auto nearest = base::Nearest(member.name, names)) {
          Refuse(table.place, fmt::format("{}: there is no such step: did you mean {}?",
                                          base::Printable(member.name), *nearest));
          return std::nullopt;
        }
      }
      Refuse(table.place, fmt::format("a step is one of {}, such as {{ {} }}",
                                      fmt::join(names, ", "), Kinds()[1].example));
      return std::nullopt;
    }
    std::vector<std::string_view> known = kind->keys;
    known.push_back(kind->name);
    known.push_back("within");
    CheckKeys(table, known, kind->name);
    Step step{.kind = kind->kind, .line = table.place.line};
    step.within = ReadDuration(table, "within", limit_);
    const std::vector<std::string> texts = ReadTexts(*own);
    if (texts.empty()) return std::nullopt;
    const bool is_command = step.kind == StepKind::kSimulate || step.kind == StepKind::kSend;
    step.text = fmt::format("{} {}", kind->name, base::Join(texts, is_command ? " " : ", "));
    const bool is_right =
        is_command ? ReadCommand(table, *own, texts, step) : ReadLook(table, *own, texts, step);
    return is_right ? std::optional(std::move(step)) : std::nullopt;
  }

  bool ReadCommand(const TomlValue& table, const TomlMember& own,
                   const std::vector<std::string>& texts, Step& step) {
    step.words = texts;
    if (own.value.type == Type::kText) {
      if (texts.front().find_first_of("'\"\\") != std::string::npos) {
        Refuse(own.place, fmt::format("{0}: words that need quotation marks are a list: {0} = "
                                      "[\"action\", \"beep\", \"KIT/0001\"]",
                                      own.name));
        return false;
      }
      std::string text = texts.front();
      std::replace_if(
          text.begin(), text.end(), [](char c) { return c == '\n' || c == '\t'; }, ' ');
      step.words = base::Split(text, ' ');
      std::erase(step.words, "");
    }
    if (step.words.front() == "fleetpub") step.words.erase(step.words.begin());
    if (step.kind == StepKind::kSimulate) step.words.insert(step.words.begin(), "simulate");
    step.payload = ReadText(table, "payload");
    step.outcome = ReadText(table, "outcome");
    std::vector<std::string_view> names;
    names.reserve(message::kCommandStatuses.size());
    for (const auto& facts : message::kCommandStatuses) names.push_back(facts.name);
    if (!step.outcome.empty() &&
        std::find(names.begin(), names.end(), step.outcome) == names.end()) {
      Refuse(Find(table, "outcome")->place,
             fmt::format("outcome is one of {}", fmt::join(names, ", ")));
    }
    bool is_right = CheckVariables(own.place, step.payload);
    for (const std::string& word : step.words) {
      is_right = CheckVariables(own.place, word) && is_right;
    }
    if (!is_right) return false;
    if (auto ok = check_(step); !ok) {
      Refuse(own.place, fmt::format("{}: {}", own.name, ok.error().message));
      return false;
    }
    return true;
  }

  bool ReadLook(const TomlValue& table, const TomlMember& own,
                const std::vector<std::string>& texts, Step& step) {
    const auto robot = Find(table, "robot") == nullptr ? robot_ : ReadRobot(table);
    if (!robot && Find(table, "robot") == nullptr) {
      Refuse(table.place, "whose message? write robot = \"KIT/0001\", here or below [[test]]");
    }
    if (!robot) return false;
    step.robot = *robot;
    if (Find(table, "topic") != nullptr) step.topic = ReadText(table, "topic");
    const auto& topics = vda5050::kTopicNames;
    if (std::find(topics.begin(), topics.end(), step.topic) == topics.end()) {
      Refuse(Find(table, "topic")->place,
             fmt::format("topic is one of {}", fmt::join(topics, ", ")));
      return false;
    }
    step.hold = ReadDuration(table, "for", milliseconds(0));
    if (step.kind == StepKind::kCapture) return ReadCapture(table, own, texts, step);
    step.conditions = texts;
    bool is_right = true;
    for (const std::string& text : texts) {
      is_right =
          CheckVariables(own.place, text) && CheckCondition(own, text, step.topic) && is_right;
    }
    return is_right;
  }

  bool CheckCondition(const TomlMember& own, const std::string& text, const std::string& topic) {
    const auto condition = vda5050::ParseCondition(text);
    // What a variable will say is not known.
    const bool is_known = condition && text.find("${") == std::string::npos;
    const auto checked =
        is_known ? vda5050::CheckCondition(*condition, topic) : Result<std::string>("");
    if (condition && checked) return true;
    Refuse(own.place, (condition ? checked.error() : condition.error()).message);
    return false;
  }

  bool ReadCapture(const TomlValue& table, const TomlMember& own,
                   const std::vector<std::string>& texts, Step& step) {
    step.path = texts.front();
    step.name = ReadText(table, "as");
    if (!CheckVariables(own.place, step.path)) return false;
    // As the path of a condition.
    const auto condition = vda5050::ParseCondition(step.path + "=");
    const bool is_plain =
        own.value.type == Type::kText && step.path.find("${") == std::string::npos;
    if (!is_plain || !condition || condition->path != step.path) {
      Refuse(own.place,
             R"(capture takes one member: capture = "orderId", or "/actionStates/0/actionId")");
      return false;
    }
    if (!IsName(step.name)) {
      Refuse(table.place, R"(capture gives a name, of letters and digits: as = "order")");
      return false;
    }
    if (captured_.insert(step.name).second) return true;
    Refuse(Find(table, "as")->place,
           fmt::format("as: {} is captured already: choose another name", step.name));
    return false;
  }

  bool CheckVariables(TomlPlace place, std::string_view text) {
    const auto names = FindVariables(text);
    if (!names) {
      Refuse(place, names.error().message);
      return false;
    }
    for (const std::string& name : *names) {
      if (captured_.contains(name)) continue;
      Refuse(place, fmt::format("${{{0}}}: no step before this one says as = \"{0}\"", name));
      return false;
    }
    return true;
  }

  const std::string& file_;
  const config::Config& config_;
  const CommandCheck& check_;
  config::Mistakes& mistakes_;
  milliseconds limit_ = kUsualLimit;
  std::optional<vda5050::RobotAddress> robot_;   // of the test
  std::set<std::string, std::less<>> captured_;  // so far in the test
};

}  // namespace

std::vector<std::string> Test::ListReal() const {
  std::set<std::string> simulated;
  std::vector<std::string> real;
  for (const Step& step : steps) {
    if (step.kind == StepKind::kSimulate) {
      simulated.insert(step.targets.begin(), step.targets.end());
    }
    if (step.kind != StepKind::kSend) continue;
    for (const std::string& target : step.targets) {
      const bool is_told = std::find(real.begin(), real.end(), target) != real.end();
      if (!simulated.contains(target) && !is_told) real.push_back(target);
    }
  }
  return real;
}

Suite ReadSuite(std::string_view text, const std::string& file, const config::Config& config,
                const CommandCheck& check, config::Mistakes& mistakes) {
  Suite suite{.file = file, .tests = {}};
  const auto document = config::ParseToml(text);
  if (!document) {
    mistakes.push_back({ErrorKind::kUsage,
                        fmt::format("{}:{}", base::Printable(file), document.error().message),
                        document.error().detail});
    return suite;
  }
  suite.tests = Reader(file, config, check, mistakes).Read(*document);
  return suite;
}

Result<std::vector<std::string>> FindVariables(std::string_view text) {
  std::vector<std::string> names;
  for (auto at = text.find("${"); at != std::string_view::npos; at = text.find("${", at + 2)) {
    const std::string_view name = text.substr(at + 2, text.find('}', at) - at - 2);
    if (!IsName(name) || at + 2 + name.size() == text.size()) {
      return Fail(ErrorKind::kUsage, "a variable is written ${name}, of letters and digits");
    }
    names.emplace_back(name);
  }
  return names;
}

std::string Expand(std::string_view text, const Variables& variables, Into into) {
  std::string expanded;
  for (;;) {
    const auto at = text.find("${");
    expanded += text.substr(0, at);
    if (at == std::string_view::npos) return expanded;
    const auto end = text.find('}', at);
    const base::JsonValue& value = variables.find(text.substr(at + 2, end - at - 2))->second;
    std::string json = base::ToJson(value);
    if (value.IsString()) {
      json =
          into == Into::kJson ? json.substr(1, json.size() - 2) : std::string(base::ToView(value));
    }
    expanded += json;
    text.remove_prefix(end + 1);
  }
}

}  // namespace fleetpub::app::scenario
