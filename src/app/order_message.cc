#include "app/order_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "app/order_update.h"
#include "base/text.h"
#include "base/time.h"
#include "vda5050/messages/order.h"
#include "vda5050/model/robot_address.h"
#include "vda5050/rules/preflight.h"

namespace fleetpub::app {
namespace {

using base::Printable;
using vda5050::OrderWriter;
using vda5050::Shown;

tl::unexpected<Error> Refuse(std::string reason) {
  return Fail(ErrorKind::kPreflight, std::move(reason));
}

// Modes in which fleet control gives orders; from 3.0 INTERVENED takes them for later (3.0 §6.6.7,
// 2.1 §6.10.4).
bool TakesOrders(std::string_view mode, vda5050::Version version) {
  return mode.empty() || mode == "AUTOMATIC" || mode == "SEMIAUTOMATIC" ||
         (mode == "INTERVENED" && version >= vda5050::Version::k300);
}

class OrderComposer {
 public:
  OrderComposer(const OrderTask& task, const OrderRobot& robot, const LedgerHook& open_ledger)
      : task_(task),
        robot_(robot),
        open_ledger_(open_ledger),
        writer_(robot.dialect.version, robot.factsheet, task.without) {}

  Result<ComposedOrder> Run() {
    Status ok = CheckMode();
    if (ok) ok = task_.kind == OrderKind::kNew ? ComposeNew() : ComposeUpdate();
    if (ok) ok = CheckWriting();
    if (!ok) return Fail(std::move(ok.error()));
    return std::move(composed_);
  }

 private:
  [[nodiscard]] std::string Name() const { return Printable(robot_.address.ToString()); }

  void Note(std::string text) {
    composed_.notes.push_back(fmt::format("{}: {}", Name(), std::move(text)));
  }

  Status OpenLedger() {
    if (ledger_) return {};
    auto ledger = open_ledger_(ledger::OpenMode::kReadOnly);
    if (!ledger) return Fail(std::move(ledger.error()));
    ledger_ = *std::move(ledger);
    return {};
  }

  Status CheckMode() const {
    if (robot_.state == nullptr || !task_.check) return {};
    const std::string& mode = robot_.state->operating_mode;
    if (TakesOrders(mode, robot_.dialect.version)) return {};
    return Refuse(
        fmt::format("it is in mode {}, in which it takes no orders: switch it to "
                    "AUTOMATIC, or send with --no-check",
                    Shown(mode)));
  }

  // --- A new order

  Status ComposeNew() {
    const bool is_busy = robot_.state != nullptr && IsUnderWay(*robot_.state);
    if (is_busy && task_.check && !task_.replaces) return RefuseSecond();
    if (robot_.state == nullptr && task_.check && task_.is_online) {
      Note("it sent no state: whether it drives another order is not known");
    }
    const std::string id =
        task_.order_id.empty() ? vda5050::MakeActionId(robot_.factsheet) : task_.order_id;
    if (auto ok = CheckUnused(id); !ok) return ok;
    const PathRobot from{
        .address = robot_.address,
        .factsheet = robot_.factsheet,
        .state = robot_.state,
        .start = robot_.state == nullptr || !task_.check ? "" : robot_.state->last_node_id,
        .is_checked = task_.check,
        .continues = task_.replaces};
    auto planned = PlanPath(task_.path, task_.site.get(), from);
    if (!planned) return Fail(std::move(planned.error()));
    const std::size_t count = planned->path.nodes.size();
    const std::size_t released = std::clamp<std::size_t>(task_.release.value_or(count), 1, count);
    std::vector<std::string> nodes;
    std::vector<std::string> edges;
    Write(planned->path, 0, 0, released, nodes, edges);
    if (auto ok = CheckLimits(nodes.size(), edges.size(), released); !ok) return ok;
    composed_.message = vda5050::MakeOrder(id, 0, "", nodes, edges);
    Describe(*planned, DescribePath(*planned), released, count);
    return {};
  }

  // Whose order it drives, and how far it is.
  Status RefuseSecond() {
    const vda5050::RobotState& state = *robot_.state;
    std::string by = "not sent from this ledger";
    if (auto ok = OpenLedger(); ok) {
      const auto history = ReadHistoryOf(state.order_id);
      if (history && !history->sent.empty()) {
        const SentOrder& sent = history->sent.front();
        by = fmt::format("sent by {} {} ago", Printable(sent.by),
                         base::FormatElapsed(base::WallTime::clock::now() - sent.at));
      }
    }
    return Refuse(fmt::format(
        "it has order {}, {}, and is at {}; order replace cancels that first. try: "
        "fleetpub order follow {}",
        Shown(state.order_id), by, base::NonEmptyOr(Shown(state.last_node_id), "no node"), Name()));
  }

  // A robot passes over, in silence, an order of an id that it has had (2.1 §6.6.4).
  Status CheckUnused(const std::string& id) {
    if (task_.order_id.empty()) return {};
    if (robot_.state != nullptr && robot_.state->order_id == id) {
      return Refuse(
          fmt::format("it has had order {} already: ids are used once: leave "
                      "--order-id out",
                      Printable(id)));
    }
    if (auto ok = ReadHistory(id); !ok) return ok;
    if (history_.sent.empty()) return {};
    return Refuse(
        fmt::format("order {} was sent to it before, by {}: ids are used once: "
                    "leave --order-id out",
                    Printable(id), Printable(history_.sent.back().by)));
  }

  [[nodiscard]] Result<OrderHistory> ReadHistoryOf(const std::string& id) const {
    return ReadOrderHistory(*ledger_, robot_.brokers, robot_.address.ToString(), id);
  }

  // The next header id first: what comes between is seen either here or when it is sent.
  Status ReadHistory(const std::string& id) {
    if (auto ok = OpenLedger(); !ok) return ok;
    const auto topic =
        vda5050::TopicFor(robot_.dialect.topics, robot_.dialect.version, robot_.address, "order");
    if (!topic) return Fail(topic.error());
    auto next = ledger_->PeekNext(*topic);
    if (!next) return Fail(std::move(next.error()));
    auto history = ReadHistoryOf(id);
    if (!history) return Fail(std::move(history.error()));
    history_ = *std::move(history);
    composed_.expected_header_id = *next;
    return {};
  }

  // --- An update

  Status ComposeUpdate() {
    if (robot_.state == nullptr) {
      return Refuse(
          "it sent no state, so which order it has is not known: --state-wait 35s waits for one");
    }
    if (auto ok = ReadHistory(robot_.state->order_id); !ok) return ok;
    if (auto ok = CheckAlone(*robot_.state); !ok) return ok;
    auto order = CurrentOrder::Find(history_, *robot_.state, Name());
    if (!order) return Fail(std::move(order.error()));
    const std::size_t horizon = order->horizon();
    if (task_.kind == OrderKind::kExtend) return Extend(*order, horizon);
    if (horizon == 0) {
      return Refuse(
          fmt::format("order {} has no horizon: all its nodes are released", Shown(order->id())));
    }
    const std::size_t released = std::min(task_.release.value_or(horizon), horizon);
    composed_.message = order->MakeUpdate(released);
    const auto names = order->horizon_nodes();
    Note(fmt::format("releases {}{}", Printable(base::Join(std::span(names).first(released), ", ")),
                     DescribeRest(horizon - released)));
    return {};
  }

  // An update that is on its way to the robot begins where this one would.
  Status CheckAlone(const vda5050::RobotState& state) const {
    constexpr std::chrono::seconds kOnItsWay{3};
    for (const SentOrder& sent : history_.sent) {
      const auto ago = std::chrono::abs(base::WallTime::clock::now() - sent.at);
      const bool is_known =
          sent.was_rejected || sent.update_id <= state.order_update_id.value_or(0);
      if (is_known || ago > kOnItsWay) continue;
      return Refuse(
          fmt::format("update {} was sent to it by {} {} ago, and its state does not show it yet: "
                      "try again",
                      sent.update_id, Printable(sent.by), base::FormatElapsed(ago)));
    }
    return {};
  }

  Status Extend(CurrentOrder& order, std::size_t horizon) {
    PathRequest path = task_.path;
    const std::string last = order.last_node();
    if (!path.nodes.empty() && path.nodes.front() != last) {
      path.nodes.insert(path.nodes.begin(), last);
    }
    if (!path.points.empty() && path.points.front().node != last) {
      path.points.insert(path.points.begin(), {.node = last, .position = {}, .actions = {}});
    }
    const PathRobot from{.address = robot_.address,
                         .factsheet = robot_.factsheet,
                         .state = robot_.state,
                         .start = last,
                         .continues = true};
    auto planned = PlanPath(path, task_.site.get(), from);
    if (!planned) return Fail(std::move(planned.error()));
    if (!planned->path.nodes.front().actions.empty() && !path.actions.empty()) {
      Note(fmt::format("actions at {} are left out: it is part of the order already",
                       Printable(last)));
    }
    const std::size_t added = planned->path.nodes.size() - 1;
    if (added == 0) return Refuse(fmt::format("its order ends at {} already", Printable(last)));
    std::vector<std::string> nodes;
    std::vector<std::string> edges;
    Write(planned->path, 1, order.last_sequence_id(), 0, nodes, edges);
    order.Append(std::move(nodes), std::move(edges));
    const std::size_t whole = horizon + added;
    const std::size_t released = std::min(task_.release.value_or(horizon > 0 ? 0 : whole), whole);
    if (auto ok = CheckLimits(whole + 1, whole, released + 1); !ok) return ok;
    composed_.message = order.MakeUpdate(released);
    Describe(*planned, DescribePath(*planned), released + 1, whole + 1);
    return {};
  }

  // --- Both

  // From the node `first` on; the node before that has `sequence_id`.
  void Write(const vda5050::OrderPath& path, std::size_t first, std::uint32_t sequence_id,
             std::size_t released, std::vector<std::string>& nodes,
             std::vector<std::string>& edges) {
    for (std::size_t i = first; i < path.nodes.size(); ++i) {
      const bool is_released = i < released;
      if (i > 0) {
        edges.push_back(writer_.WriteEdge(path.edges[i - 1], ++sequence_id, is_released,
                                          path.nodes[i - 1].id, path.nodes[i].id));
        ++sequence_id;
      }
      nodes.push_back(writer_.WriteNode(path.nodes[i], sequence_id, is_released));
    }
  }

  [[nodiscard]] static std::string DescribeRest(std::size_t nodes) {
    if (nodes == 0) return "";
    return fmt::format("; {} node{} not released", nodes, nodes == 1 ? " is" : "s are");
  }

  void Describe(const PlannedPath& planned, const std::string& path, std::size_t released,
                std::size_t nodes) {
    Note(path + DescribeRest(nodes - released));
    for (const std::string& warning : planned.warnings) Note(warning);
  }

  Status CheckLimits(std::size_t nodes, std::size_t edges, std::size_t base) const {
    if (robot_.factsheet == nullptr || !task_.check) return {};
    std::string reason = vda5050::CheckOrderLimits(*robot_.factsheet, nodes, edges, base);
    if (reason.empty()) return {};
    return Refuse(std::move(reason));
  }

  Status CheckWriting() {
    if (!writer_.refusals().empty()) {
      return Refuse(base::Join(writer_.refusals(), "; "));
    }
    if (!writer_.left_out().empty()) {
      const std::vector<std::string> names(writer_.left_out().begin(), writer_.left_out().end());
      Note(fmt::format("left out, as its factsheet does not list {}: {}",
                       names.size() == 1 ? "it" : "them", base::Join(names, ", ")));
    }
    return {};
  }

  const OrderTask& task_;
  const OrderRobot& robot_;
  const LedgerHook& open_ledger_;
  OrderWriter writer_;
  std::unique_ptr<ledger::Ledger> ledger_;
  OrderHistory history_;
  ComposedOrder composed_;
};

class OrderMessage final : public RobotMessage {
 public:
  OrderMessage(std::shared_ptr<const OrderTask> task, LedgerHook ledger)
      : task_(std::move(task)), ledger_(std::move(ledger)) {}

  [[nodiscard]] bool IsMadeForRobot() const override { return true; }

  [[nodiscard]] Status Prepare(const vda5050::ListedRobot& robot,
                               const std::vector<std::string>& brokers,
                               std::vector<std::string>& notes) override {
    const auto& [address, entry] = robot;
    auto composed = ComposeOrder(*task_,
                                 {.address = address,
                                  .dialect = *entry.Spoken(),
                                  .factsheet = task_->check ? entry.factsheet.get() : nullptr,
                                  .state = entry.state.get(),
                                  .brokers = brokers},
                                 ledger_);
    if (!composed) return Fail(std::move(composed.error()));
    constexpr std::size_t kHeader = 256;
    const std::size_t bytes = base::ToJson(composed->message).size() + kHeader;
    const std::size_t limit = entry.factsheet ? entry.factsheet->limits.message_length : 0;
    if (task_->check && limit > 0 && bytes > limit) {
      return Refuse(
          fmt::format("an order of {} bytes is longer than the robot takes, {}", bytes, limit));
    }
    std::move(composed->notes.begin(), composed->notes.end(), std::back_inserter(notes));
    composed_ = *std::move(composed);
    return {};
  }

  [[nodiscard]] Result<message::Command> Build(
      const vda5050::RobotAddress& robot, const vda5050::Dialect& dialect,
      std::optional<std::uint32_t> header_id) const override {
    if (composed_) return BuildOrder(*composed_, robot, dialect, header_id);
    // Before Prepare() it stands for whatever is not sent.
    const ComposedOrder nothing{.message = vda5050::MakeOrder(task_->order_id, 0, "", {}, {})};
    return BuildOrder(nothing, robot, dialect, header_id);
  }

  [[nodiscard]] vda5050::PreflightFindings Check(const vda5050::RobotAddress& robot,
                                                 const vda5050::Dialect& dialect,
                                                 const vda5050::KnownRobot& known) const override {
    return vda5050::CheckRobot(robot, dialect, {}, known);
  }

  [[nodiscard]] Result<std::unique_ptr<message::ResponseTracker>> Track(
      const vda5050::RobotAddress& robot, const vda5050::Dialect& dialect,
      vda5050::WaitFor wait_for) const override {
    return vda5050::TrackUserMessage(robot, dialect, "order", composed_->message, wait_for);
  }

 private:
  std::shared_ptr<const OrderTask> task_;
  LedgerHook ledger_;
  std::optional<ComposedOrder> composed_;
};

}  // namespace

Result<ComposedOrder> ComposeOrder(const OrderTask& task, const OrderRobot& robot,
                                   const LedgerHook& ledger) {
  return OrderComposer(task, robot, ledger).Run();
}

Result<message::Command> BuildOrder(const ComposedOrder& order, const vda5050::RobotAddress& robot,
                                    const vda5050::Dialect& dialect,
                                    std::optional<std::uint32_t> header_id) {
  auto command = vda5050::BuildUserMessage(robot, dialect, "order", order.message,
                                           vda5050::HeaderMismatch::kReplace, header_id);
  if (command) command->expected_header_id = order.expected_header_id;
  return command;
}

std::unique_ptr<RobotMessage> MakeOrderMessage(std::shared_ptr<const OrderTask> task,
                                               LedgerHook ledger) {
  return std::make_unique<OrderMessage>(std::move(task), std::move(ledger));
}

}  // namespace fleetpub::app
