#include "cli/options/soar_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/file.h"
#include "base/json.h"
#include "base/text.h"
#include "cli/parser/option_set.h"

namespace fleetpub::cli {
namespace {

constexpr const char* kSoar = "SoAR";
constexpr const char* kAcknowledging = "Waiting";

tl::unexpected<Error> Usage(std::string message) {
  return Fail(ErrorKind::kUsage, std::move(message));
}

const char* TypeName(soar::FieldType type) {
  switch (type) {
    case soar::FieldType::kInteger:
      return "N";
    case soar::FieldType::kNumber:
      return "NUMBER";
    case soar::FieldType::kBoolean:
      return "BOOL";
    case soar::FieldType::kDateTime:
      return "TIME";
    case soar::FieldType::kJson:
      return "JSON";
    case soar::FieldType::kText:
      return "TEXT";
  }
  return "TEXT";
}

// `plan-id` for autonomy_engine_plan_ID, `heading` for heading.
std::string OptionName(const soar::Field& field) {
  std::string name =
      base::ToLower(field.short_names[0].empty() ? field.name : field.short_names[0]);
  // A place alone is said in full: `--latitude`, while `lat` is for lists.
  if (name == "lat" || name == "lon") name = field.name;
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

// A topic filter; dots are taken for slashes where there are none.
Result<std::string> ParseFilter(std::string filter) {
  if (filter.find('/') == std::string::npos) std::replace(filter.begin(), filter.end(), '.', '/');
  const auto refuse = [&](std::string_view why) {
    return Usage(fmt::format("--ack-topic '{}' is refused: {}", base::Printable(filter), why));
  };
  if (filter.empty()) return refuse("it is empty");
  if (!base::IsUtf8(filter) || base::Printable(filter) != filter) {
    return refuse("it has a control character or is not valid UTF-8");
  }
  const auto levels = base::Split(filter, '/');
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const bool has_wildcard = levels[i].find_first_of("+#") != std::string::npos;
    if (has_wildcard && levels[i].size() > 1) return refuse("a wildcard is a whole level");
    if (levels[i] == "#" && i + 1 < levels.size()) return refuse("# is the last level");
  }
  return filter;
}

}  // namespace

void DeclarePrefix(OptionSet& set, std::string& prefix) {
  set.AddOption("--prefix", prefix, "First level of all topics of the backbone [soar]")
      .Variable("FLEETPUB_SOAR_PREFIX")
      .Group(kSoar)
      .Key("soar_prefix");
}

void DeclareSource(OptionSet& set, std::string& source) {
  set.AddOption("--source", source, "Who sends [fleetpub]")
      .Variable("FLEETPUB_SOAR_SOURCE")
      .Group(kSoar)
      .Key("soar_source");
}

void DeclareSoarOptions(OptionSet& set, SoarOptions& o) {
  const auto add = [&](const char* names, std::string& value, const char* type, const char* help) {
    return set.AddOption(names, value, help).Type(type).Group(kSoar);
  };
  set.AddOption("destination", o.destination, "Who it is for: soar.planet-ocean.ecosub.eco1")
      .Type("DESTINATION");
  set.AddFlag("--broadcast", o.broadcast, "To everybody, instead of a destination").Group(kSoar);
  DeclareSource(set, o.source);
  DeclarePrefix(set, o.prefix);
  add("--header-version", o.header_version, "N", "The header's version [1.0]");
  set.AddFlag("--strict", o.strict, "Doubtful values are errors, not warnings").Group(kSoar);
}

void DeclareSoarWaiting(OptionSet& set, SoarWaitingOptions& o) {
  set.AddFlag("-w,--wait", o.wait, "Wait until it is acknowledged as executed")
      .Group(kAcknowledging);
  const auto add = [&](const char* names, ValueKind kind, const char* type, const char* help) {
    set.AddOption(names, std::move(kind), help).Type(type).Group(kAcknowledging);
  };
  add("--wait-for", OneOf(o.wait_for, soar::kLevels), "LEVEL", "Wait for {}");
  add("-W,--timeout", Duration(o.timeout), "TIME",
      "How long to wait in total [35s to be seen, then 10m]");
  add("--acks", WholeNumber(o.acknowledgements, 1, 100'000), "N",
      "So many must acknowledge a broadcast [1]");
  set.AddOption("--ack-topic", o.topics,
                "Where acknowledgements come back, + and # allowed; repeatable "
                "[the destination's from_platform.acknowledgement]")
      .Type("TOPIC")
      .OneValueEach()
      .Group(kAcknowledging);
}

Result<soar::Sender> ParseSender(const SoarOptions& options) {
  auto prefix = soar::ParsePrefix(options.prefix);
  if (!prefix) return Fail(std::move(prefix.error()));
  if (auto source = soar::CheckSource(options.source); !source) return Fail(source.error());
  const auto version = base::ParseJson(options.header_version);
  if (!version || !version->IsNumber()) {
    return Usage(fmt::format("--header-version takes a number such as 1.0, not '{}'",
                             base::Printable(options.header_version)));
  }
  return soar::Sender{*std::move(prefix), options.source, options.header_version,
                      options.strict ? soar::Strictness::kRefuse : soar::Strictness::kWarn};
}

Result<soar::Destination> ParseDestination(const SoarOptions& options, const soar::Sender& sender,
                                           soar::MessageType type) {
  if (options.broadcast) {
    if (options.destination.empty()) return soar::Broadcast(sender.prefix);
    return Usage(fmt::format("--broadcast is for everybody: leave out the destination '{}'",
                             base::Printable(options.destination)));
  }
  if (options.destination.empty()) {
    return Usage("name a destination, such as soar.planet-ocean.ecosub.eco1, or --broadcast");
  }
  return soar::ParseDestination(options.destination, sender.prefix, type);
}

Result<SoarWaiting> ParseSoarWaiting(const SoarWaitingOptions& options,
                                     const soar::Destination& destination) {
  SoarWaiting waiting;
  waiting.wait_for = options.wait_for;
  if (!waiting.wait_for && options.wait) waiting.wait_for = soar::Level::kExecuted;
  const bool more = options.timeout || options.acknowledgements || !options.topics.empty();
  if (!waiting.wait_for && more) {
    return Usage("--timeout, --acks and --ack-topic need --wait");
  }
  waiting.wait.total = options.timeout;
  waiting.count = options.acknowledgements.value_or(1);
  if (waiting.count > 1 && destination.platform) {
    return Usage(fmt::format("--acks {}: {} is one platform, which acknowledges once",
                             waiting.count, base::Printable(destination.name)));
  }
  for (const std::string& topic : options.topics) {
    auto filter = ParseFilter(topic);
    if (!filter) return Fail(std::move(filter.error()));
    waiting.topics.push_back(*std::move(filter));
  }
  return waiting;
}

void FieldOptions::Declare(OptionSet& set, std::span<const soar::Field> fields) {
  for (const soar::Field& field : fields) {
    const std::string name = OptionName(field);
    std::string names = "--" + name;
    // Below a parent the format's own name says too little.
    if (name != field.name && field.parent.empty()) names += fmt::format(",--{}", field.name);
    Given& given = given_.emplace_back();
    given.field = &field;
    ValueKind kind = Text(given.text);
    if (!field.choices[0].empty()) {
      kind.choices = [&field] {
        std::vector<std::string_view> choices(field.choices.begin(), field.choices.end());
        std::erase(choices, "");
        return choices;
      };
    }
    given.option = set.AddOption(names, std::move(kind), std::string(field.meaning))
                       .Type(TypeName(field.type))
                       .Group("Payload");
  }
}

Result<std::vector<soar::Member>> FieldOptions::Members() const {
  std::vector<soar::Member> members;
  for (const auto& [field, option, text] : given_) {
    if (!option.IsGiven()) {
      if (!field->required) continue;
      return Usage(
          fmt::format("{} is missing: give it with --{}", field->name, OptionName(*field)));
    }
    std::string content = text;
    if (field->type == soar::FieldType::kJson && text.starts_with('@')) {
      auto file = base::ReadFile(text.substr(1));
      if (!file) return Fail(std::move(file.error()));
      content = *std::move(file);
    }
    auto member = soar::ParseField(*field, content);
    if (!member) return Usage(std::move(member.error().message));
    members.push_back(*std::move(member));
  }
  return members;
}

}  // namespace fleetpub::cli
