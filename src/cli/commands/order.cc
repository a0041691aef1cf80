// `fleetpub order TARGET NODE…` sends a robot along nodes or to a place of the layout; `extend`,
// `release`, `replace` and `follow` are the life of that order.
#include <fmt/format.h>

#include <memory>
#include <set>

#include "app/follow_order.h"
#include "app/order_message.h"
#include "app/path_file.h"
#include "base/file.h"
#include "base/text.h"
#include "cli/environment.h"
#include "cli/instant_sending.h"
#include "cli/layout_file.h"
#include "cli/one_robot.h"
#include "cli/output/sending_observer.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "layout/layout.h"

namespace fleetpub::cli {
namespace {

using app::OrderKind;
using app::OrderTask;

constexpr std::string_view kExample = "fleetpub order KIT/0001 n1 n2";

constexpr auto kBlockingTypes = std::to_array<std::string_view>({"NONE", "SOFT", "SINGLE", "HARD"});

struct OrderOptions : RobotOptions {
  std::vector<std::string> nodes;
  std::string to;
  std::vector<std::string> via;
  std::string from;
  std::string route_file;
  std::string layout_file;
  std::string vehicle_type;
  bool loaded = false;
  std::string load_set;
  layout::RouteCost cost = layout::RouteCost::kLength;
  std::vector<std::string> actions;
  std::string blocking_type;
  std::optional<double> deviation_xy;
  std::optional<double> deviation_theta;
  std::vector<std::string> without;
  std::string order_id;
  std::optional<std::size_t> release;
  std::string release_word;  ///< of `order release`: a number, or `all`
  bool auto_release = false;
  std::optional<std::uint32_t> header_id;
  SendingOptions sending;
  WaitingOptions waiting;
};

// --- Declaring

void DeclarePath(OptionSet& set, OrderOptions& o) {
  constexpr const char* kWay = "Way";
  set.AddOption("nodes", Name(o.nodes), "Its nodes, or stations of the layout, in their order")
      .Type("NODE");
  set.AddOption("--to", Name(o.to), "Find the way to this node or station of the layout")
      .Type("PLACE")
      .Group(kWay);
  set.AddOption("--via", Name(o.via), "By way of this one; repeatable, in their order")
      .Type("PLACE")
      .OneValueEach()
      .Group(kWay);
  set.AddOption("--from", Name(o.from), "Where the way begins [the robot's last node]")
      .Type("NODE")
      .Group(kWay);
  set.AddOption("--route", Name(o.route_file), "Rows node,x,y,theta,map,actions in place of NODEs")
      .Type("FILE")
      .Group(kWay);
  set.AddOption("--layout", o.layout_file, "The layout, a LIF file [of the configuration]")
      .Type("FILE")
      .Key("layout")
      .Group(kWay);
  set.AddOption("--by", OneOf(o.cost, layout::kRouteCosts), "What the way is short in: {} [length]")
      .Type("WORD")
      .Group(kWay);
  set.AddOption("--vehicle-type", o.vehicle_type, "The layout's name for it [manufacturer.series]")
      .Type("TYPE")
      .Group(kWay);
  set.AddFlag("--loaded", o.loaded, "Only where it may go with a load [as the robot says]")
      .Group(kWay);
  set.AddOption("--load-set", o.load_set, "The kind of its load").Type("NAME").Group(kWay);
}

void DeclareContents(OptionSet& set, OrderOptions& o) {
  constexpr const char* kOrder = "Order";
  set.AddOption("--action", o.actions,
                "What to do at a node, station or edge, with its parameters: pick@n7 "
                "loadType=EPAL; repeatable")
      .Type("TYPE@PLACE")
      .Group(kOrder);
  set.AddOption("--blocking-type", OneOf(o.blocking_type, kBlockingTypes),
                "Of these actions: {} [the layout's, else HARD]")
      .Group(kOrder);
  set.AddOption("--deviation-xy", Measure(o.deviation_xy, vda5050::ParameterType::kLength),
                "allowedDeviationXY: how far from a node counts as there, in m")
      .Type("M")
      .Group(kOrder);
  set.AddOption("--deviation-theta", Measure(o.deviation_theta, vda5050::ParameterType::kAngle),
                "allowedDeviationTheta, in rad")
      .Type("RAD")
      .Group(kOrder);
  set.AddOption("--without", o.without,
                "Leave out this member, whatever the layout says: maxSpeed; repeatable")
      .Type("MEMBER")
      .OneValueEach()
      .Group(kOrder);
}

void DeclareRelease(OptionSet& set, OrderOptions& o, const std::string& help) {
  set.AddOption("--release", WholeNumber(o.release, 1, 1'000'000), help).Group("Order");
}

void DeclareSending(OptionSet& set, OrderOptions& o) {
  set.AddOption("--header-id", WholeNumber(o.header_id),
                "The headerId, above the topic's last [the next]")
      .Group("Order");
  DeclareSendingOptions(set, o.sending);
  DeclareWaitingOptions(set, o.waiting);
}

// --- Reading

Result<app::PathRequest> ParsePath(const OrderOptions& o) {
  app::PathRequest path{.nodes = o.nodes,
                        .points = {},
                        .stops = o.via,
                        .from = o.from,
                        .actions = {},
                        .blocking_type = o.blocking_type,
                        .vehicle_type = o.vehicle_type,
                        .loaded = o.loaded,
                        .load_set = o.load_set,
                        .cost = o.cost,
                        .deviation_xy = o.deviation_xy,
                        .deviation_theta = o.deviation_theta};
  if (!o.to.empty()) path.stops.push_back(o.to);
  const int ways = static_cast<int>(!o.nodes.empty()) + static_cast<int>(!o.to.empty()) +
                   static_cast<int>(!o.route_file.empty());
  if (ways != 1 || (o.to.empty() && !(o.via.empty() && o.from.empty()))) {
    return Fail(ErrorKind::kUsage,
                ways == 0 ? "where to? Nodes, a place or a file say it. try: fleetpub order " +
                                base::Printable(base::NonEmptyOr(o.target, "KIT/0001")) + " --to n7"
                          : "NODEs, --to (with --via and --from) and --route exclude each other");
  }
  if (!o.route_file.empty()) {
    const auto text = base::ReadFile(o.route_file);
    if (!text) return Fail(text.error());
    auto points = app::ParsePathFile(*text);
    if (!points) {
      points.error().message = o.route_file + ": " + points.error().message;
      return Fail(std::move(points.error()));
    }
    path.points = *std::move(points);
  }
  for (std::size_t i = 0; i < o.actions.size();) {
    const std::string& word = o.actions[i++];
    std::vector<std::string> parameters;
    const auto is_parameter = [](const std::string& text) {
      const auto equals = text.find('=');
      return equals != std::string::npos && text.find('@') > equals;
    };
    while (i < o.actions.size() && is_parameter(o.actions[i])) parameters.push_back(o.actions[i++]);
    if (word.find('@') == std::string::npos) {
      return Fail(ErrorKind::kUsage,
                  fmt::format("'{}' follows --action, and is neither TYPE@PLACE nor KEY=VALUE: put "
                              "robot and nodes before --action",
                              base::Printable(word)));
    }
    auto action = app::ParsePlacedAction(word, parameters);
    if (!action) return Fail(std::move(action.error()));
    path.actions.push_back(*std::move(action));
  }
  return path;
}

Result<std::set<std::string>> ParseWithout(const OrderOptions& o) {
  std::set<std::string> names;
  std::vector<std::string_view> known;
  for (const vda5050::OrderMember& member : vda5050::OrderMembers()) {
    for (const std::string_view name : member.names) {
      if (!name.empty()) known.push_back(name);
    }
  }
  for (const std::string& name : o.without) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      const auto near = base::Nearest(name, known);
      return Fail(ErrorKind::kUsage,
                  fmt::format("--without: {} is no member that can be left out{}",
                              base::Printable(name), near ? ": did you mean " + *near + "?" : ""));
    }
    names.insert(name);
  }
  return names;
}

// Null: there is none, and none is needed.
Result<std::shared_ptr<const layout::Site>> ReadSite(const OrderOptions& o,
                                                     const Context& context) {
  if (o.layout_file.empty()) return nullptr;
  auto site = LoadLayout(o.layout_file, context.output);
  if (!site) return Fail(std::move(site.error()));
  return std::make_shared<const layout::Site>(*std::move(site));
}

Result<std::optional<std::size_t>> ParseReleaseWord(const std::string& word) {
  if (word.empty() || base::EqualsIgnoringCase(word, "all")) return std::nullopt;
  const auto count = ParseBetween<std::size_t>(word, 1, 1'000'000);
  if (count) return *count;
  return Fail(ErrorKind::kUsage,
              fmt::format("'{}' is no number of nodes, nor all. try: fleetpub order release "
                          "KIT/0001 2",
                          base::Printable(word)));
}

Result<OrderTask> MakeTask(OrderKind kind, const OrderOptions& o, const Context& context) {
  OrderTask task{
      .kind = kind, .path = {}, .site = {}, .order_id = o.order_id, .release = o.release};
  task.check = !o.waiting.no_check;
  if (o.auto_release && !o.release) {
    return Fail(ErrorKind::kUsage,
                "--auto-release needs to know how many nodes ahead: --release 3 --auto-release");
  }
  if (o.auto_release && context.options.no_history) {
    return Fail(ErrorKind::kUsage,
                "--auto-release makes its updates of what the history has: leave out --no-history "
                "(no_history in the configuration)");
  }
  if (kind == OrderKind::kRelease) {
    auto release = ParseReleaseWord(o.release_word);
    if (!release) return Fail(std::move(release.error()));
    task.release = *release;
    return task;
  }
  auto path = ParsePath(o);
  if (!path) return Fail(std::move(path.error()));
  task.path = *std::move(path);
  auto without = ParseWithout(o);
  if (!without) return Fail(std::move(without.error()));
  task.without = *std::move(without);
  auto site = ReadSite(o, context);
  if (!site) return Fail(std::move(site.error()));
  task.site = *std::move(site);
  if (task.site == nullptr && !task.path.stops.empty()) {
    return Fail(ErrorKind::kUsage,
                "--to needs a layout: --layout FILE, or layout = \"FILE\" in the configuration");
  }
  return task;
}

Result<ExitCode> Follow(const app::FollowRequest& request, const Context& context) {
  SendingObserver observer(context.output, SendingObserver::Show::kResults, FormatSite(context));
  observer.ListenForStop();
  const auto report = app::FollowOrder(request, MakeEnvironment(context), observer);
  if (!report) return Fail(report.error());
  const std::string target = report->target;
  observer.Chosen({&target, 1});
  observer.Report(*report);
  return observer.Conclude();
}

// --- Sending

Result<ExitCode> SendOrder(OrderTask task, const OrderOptions& o, const Context& context) {
  auto targets = ResolveTarget(o, kExample, context);
  if (!targets) return Fail(std::move(targets.error()));
  auto resolver = app::DialectResolver::Make(o.vda, context.config);
  if (!resolver) return Fail(std::move(resolver.error()));
  const auto settings = ParseSendingOptions(o.sending);
  if (!settings) return Fail(settings.error());
  auto waiting = ParseWaitingOptions(o.waiting);
  if (!waiting) return Fail(std::move(waiting.error()));
  // What drives takes its time.
  const auto timeout = o.waiting.timeout.value_or(std::chrono::hours(1));
  if (!o.waiting.timeout) waiting->wait.done = timeout;
  if (o.auto_release) waiting->wait_for = vda5050::WaitFor::kAccepted;
  task.is_online = !settings->dry_run;
  const app::Environment environment = MakeEnvironment(context);
  const auto shared = std::make_shared<const OrderTask>(std::move(task));
  auto sent = SendToRobots(
      {.targets = *std::move(targets),
       .resolver = *std::move(resolver),
       .title = "order",
       .needs_consent = app::NeedsConsent::kYes,
       .header_id = o.header_id,
       .make_message = [&] { return app::MakeOrderMessage(shared, environment.ledger); },
       .waiting = *waiting,
       .ask = !o.no_ask},
      *settings, context);
  if (!o.auto_release || !sent || *sent != ExitCode::kDone || settings->dry_run) return sent;
  auto request = MakeFollowRequest(o, kExample, context);
  if (!request) return Fail(std::move(request.error()));
  request->timeout = timeout;
  request->keep_released = o.release;
  request->qos = settings->qos;
  return Follow(*request, context);
}

Result<ExitCode> MakeAndSendOrder(OrderKind kind, const OrderOptions& o, const Context& context) {
  auto task = MakeTask(kind, o, context);
  if (!task) return Fail(std::move(task.error()));
  return SendOrder(*std::move(task), o, context);
}

// What it drives ends first: orders that come while it cancels are cancelled too.
Result<ExitCode> ReplaceOrder(const OrderOptions& o, const Context& context) {
  auto task = MakeTask(OrderKind::kNew, o, context);
  if (!task) return Fail(std::move(task.error()));
  task->replaces = true;
  if (o.sending.dry_run) return SendOrder(*std::move(task), o, context);
  auto request = MakeFollowRequest(o, kExample, context);
  if (!request) return Fail(std::move(request.error()));
  request->timeout = vda5050::kLongestSilence;
  const app::Environment environment = MakeEnvironment(context);
  // What is wrong with the new one is said before the old one is cancelled.
  if (task->check) {
    SendingObserver observer(context.output, SendingObserver::Show::kResults, FormatSite(context));
    observer.ListenForStop();
    const auto good = app::TryReplacing(*task, o.header_id, *request, environment, observer);
    if (observer.IsStopped()) return observer.Conclude();
    if (!good) return Fail(good.error());
  }
  task->replaces = false;
  InstantSendingOptions cancel;
  cancel.targets.words = {o.target};
  cancel.instant.vda = o.vda;
  cancel.sending = o.sending;
  cancel.waiting = o.waiting;
  cancel.waiting.wait = true;
  cancel.waiting.wait_for = vda5050::WaitFor::kFinished;
  cancel.if_any = true;
  auto cancelled = SendInstantAction(cancel, "cancelOrder", {}, context);
  if (!cancelled || *cancelled != ExitCode::kDone) return cancelled;
  {
    SendingObserver observer(context.output, SendingObserver::Show::kResults, FormatSite(context));
    observer.ListenForStop();
    const auto idle = app::AwaitIdle(*request, environment, observer);
    if (observer.IsStopped()) {
      observer.Warn("stopped: its order is cancelled, and the new one was not sent");
      return observer.Conclude();
    }
    if (!idle) return Fail(idle.error());
  }
  return SendOrder(*std::move(task), o, context);
}

void DeclareNew(OptionSet& set, OrderOptions& o) {
  DeclareRobot(set, o);
  DeclarePath(set, o);
  DeclareContents(set, o);
  DeclareRelease(set, o, "So many nodes are the base, the rest is the horizon [all]");
  set.AddFlag("--auto-release", o.auto_release,
              "Follow it, and keep so many nodes ahead of the robot released")
      .Group("Order");
  set.AddOption("--order-id", Name(o.order_id), "The orderId [a random UUID]")
      .Type("ID")
      .Group("Order");
  DeclareSending(set, o);
}

}  // namespace

Run DeclareOrder(OptionSet& set) {
  const auto options = std::make_shared<OrderOptions>();
  DeclareNew(set, *options);
  return [options](const Context& context) {
    return MakeAndSendOrder(OrderKind::kNew, *options, context);
  };
}

Run DeclareOrderReplace(OptionSet& set) {
  const auto options = std::make_shared<OrderOptions>();
  DeclareNew(set, *options);
  return [options](const Context& context) { return ReplaceOrder(*options, context); };
}

Run DeclareOrderExtend(OptionSet& set) {
  const auto options = std::make_shared<OrderOptions>();
  DeclareRobot(set, *options);
  DeclarePath(set, *options);
  DeclareContents(set, *options);
  DeclareRelease(set, *options,
                 "So many nodes behind the base [all, or none where it has a horizon]");
  DeclareSending(set, *options);
  return [options](const Context& context) {
    return MakeAndSendOrder(OrderKind::kExtend, *options, context);
  };
}

Run DeclareOrderRelease(OptionSet& set) {
  const auto options = std::make_shared<OrderOptions>();
  DeclareRobot(set, *options);
  set.AddOption("count", options->release_word, "So many nodes of the horizon, or all [all]")
      .Type("N");
  DeclareSending(set, *options);
  return [options](const Context& context) {
    return MakeAndSendOrder(OrderKind::kRelease, *options, context);
  };
}

Run DeclareOrderFollow(OptionSet& set) {
  struct FollowOptions : RobotOptions {
    std::chrono::milliseconds timeout = std::chrono::hours(1);
  };
  const auto options = std::make_shared<FollowOptions>();
  DeclareRobot(set, *options);
  set.AddOption("-W,--timeout", Duration(options->timeout), "How long to follow it [1h]")
      .Group("Waiting");
  return [options](const Context& context) -> Result<ExitCode> {
    auto request = MakeFollowRequest(*options, kExample, context);
    if (!request) return Fail(std::move(request.error()));
    request->timeout = options->timeout;
    return Follow(*request, context);
  };
}

}  // namespace fleetpub::cli
