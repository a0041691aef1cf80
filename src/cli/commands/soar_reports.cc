// `fleetpub soar acknowledge`, `soar observation`, `soar platform-status`: what platforms and their
// control systems say.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "base/json.h"
#include "base/time.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "cli/soar_sending.h"

namespace fleetpub::cli {
namespace {

using soar::MessageType;

struct SoarReportsOptions {
  MessageType type = MessageType::kAcknowledgement;
  FieldOptions fields;
  std::vector<std::string> points;
  SoarSendingOptions sending;
};

Status AddPoints(const std::vector<std::string>& texts, std::vector<soar::Member>& members) {
  std::vector<soar::Item> points;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    auto point = soar::ParseItem(soar::PointFields(), texts[i]);
    if (!point) {
      return Fail(ErrorKind::kUsage, fmt::format("point {}: {}", i + 1, point.error().message));
    }
    points.push_back(*std::move(point));
  }
  if (!points.empty()) members.push_back({"points_of_interest", soar::ItemsJson(points)});
  return {};
}

void AddTime(std::vector<soar::Member>& members) {
  constexpr std::string_view kName = "platform_timestamp";
  const bool given = std::any_of(members.begin(), members.end(),
                                 [&](const soar::Member& member) { return member.name == kName; });
  if (given) return;
  const auto now = base::FormatTimestamp(base::WallTime::clock::now());
  members.insert(members.begin(), {std::string(kName), base::JsonString(now)});
}

Result<ExitCode> RunReport(const SoarReportsOptions& options, const Context& context) {
  auto members = options.fields.Members();
  if (!members) return Fail(std::move(members.error()));
  if (auto added = AddPoints(options.points, *members); !added) return Fail(added.error());
  if (options.type == MessageType::kPlatformStatus) AddTime(*members);
  return SendSoarMessage(options.sending, options.type, soar::BuildPayload(options.type, *members),
                         context);
}

std::shared_ptr<SoarReportsOptions> DeclareReport(OptionSet& set, MessageType type) {
  auto options = std::make_shared<SoarReportsOptions>();
  options->type = type;
  options->fields.Declare(set, soar::ListFields(type));
  return options;
}

}  // namespace

Run DeclareSoarAcknowledge(OptionSet& set) {
  const auto options = DeclareReport(set, MessageType::kAcknowledgement);
  DeclareSoarSendingOnly(set, options->sending);
  return [options](const Context& context) { return RunReport(*options, context); };
}

Run DeclareSoarObservation(OptionSet& set) {
  const auto options = DeclareReport(set, MessageType::kObservation);
  set.AddOption("--point", options->points,
                "A point of interest: lat=...,lon=...[,quality=]; one each")
      .Type("LIST")
      .OneValueEach()
      .Group("Payload");
  DeclareSoarSending(set, options->sending);
  return [options](const Context& context) { return RunReport(*options, context); };
}

Run DeclareSoarPlatformStatus(OptionSet& set) {
  const auto options = DeclareReport(set, MessageType::kPlatformStatus);
  DeclareSoarSending(set, options->sending);
  return [options](const Context& context) { return RunReport(*options, context); };
}

}  // namespace fleetpub::cli
