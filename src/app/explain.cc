#include "app/explain.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "app/explain_sources.h"
#include "base/json.h"
#include "base/text.h"
#include "vda5050/reports/discovery.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::app {
namespace {

using std::chrono::microseconds;
using vda5050::kLongestSilence;
using vda5050::RobotState;
using vda5050::Shown;

std::string Evidence(const vda5050::MessageHeader& header) {
  return header.header_id ? fmt::format("state headerId {}", *header.header_id) : "a state";
}

std::string Elapsed(microseconds time) { return base::FormatElapsed(time); }

// The messages of one robot, in their order.
class Story {
 public:
  explicit Story(const ExplainRequest& request) : request_(request) {}

  void Take(const recording::Message& message, const std::string& topic_name) {
    now_ = message;
    if (topic_name == "state") {
      TakeState(message);
    } else if (topic_name == "order") {
      TakeOrder(message);
    } else if (topic_name == "instantActions") {
      TakeActions(message);
    } else if (topic_name == "connection" && !message.payload.empty()) {
      const auto connection = vda5050::ReadConnection(message.payload);
      if (connection && !connection->connection_state.empty()) {
        Tell("connection " + Shown(connection->connection_state));
      }
    }
  }

  void Take(const recording::Event& event) {
    now_ = event;
    if (event.kind == "gap" || event.kind == "overflow") {
      has_hole_ = had_hole_ = true;
      Tell(!event.text.empty()
               ? base::Printable(event.text)
               : fmt::format("the recording has a gap here{}",
                             event.lasted.count() > 0 ? " of " + Elapsed(event.lasted) : ""));
    }
  }

  [[nodiscard]] bool is_empty() const { return !order_seen_ && !taken_ && !action_seen_; }
  [[nodiscard]] std::vector<TimelineEntry> TakeTimeline() { return std::move(timeline_); }

  [[nodiscard]] std::vector<ExplainFinding> Findings() const {
    std::vector<ExplainFinding> findings;
    if (!request_.order.empty()) {
      findings.push_back(CheckTaking());
      findings.push_back(CheckNodes());
    }
    findings.push_back(CheckFailures());
    findings.push_back(CheckEnd());
    findings.push_back(CheckSilence());
    findings.push_back(CheckHeaderIds());
    return findings;
  }

 private:
  void Tell(std::string text) { timeline_.push_back({now_.at, std::move(text)}); }

  [[nodiscard]] bool IsOurs(const std::string& action_id) const {
    return action_id == request_.action || actions_.contains(action_id);
  }

  void TakeOrder(const recording::Message& message) {
    const auto order = vda5050::ReadMessage(message.payload);
    if (!order || base::StringMember(*order, "orderId") != request_.order) return;
    if (!order_seen_) order_seen_ = now_;
    std::size_t nodes = 0;
    for (const char* list : {"nodes", "edges"}) {
      const auto* elements = base::FindArray(*order, list);
      if (elements == nullptr) continue;
      if (list[0] == 'n') nodes = elements->Size();
      for (const auto& element : elements->GetArray()) {
        const auto* actions = base::FindArray(element, "actions");
        if (actions == nullptr) continue;
        for (const auto& action : actions->GetArray()) {
          actions_.emplace(base::StringMember(action, "actionId"));
        }
      }
    }
    const auto* update = base::FindMember(*order, "orderUpdateId");
    Tell(fmt::format("order {} update {} was sent: {}", Shown(request_.order),
                     update == nullptr ? "?" : base::Printable(base::ToJson(*update)),
                     base::Counted(nodes, "node")));
  }

  void TakeActions(const recording::Message& message) {
    const auto sent = vda5050::ReadMessage(message.payload);
    if (!sent) return;
    for (const char* list : {"actions", "instantActions"}) {
      const auto* actions = base::FindArray(*sent, list);
      if (actions == nullptr) continue;
      for (const auto& action : actions->GetArray()) {
        const std::string_view id = base::StringMember(action, "actionId");
        Tell(fmt::format("{} ({}) was sent", Shown(base::StringMember(action, "actionType")),
                         Shown(id)));
        if (id == request_.action) action_seen_ = true;
      }
    }
  }

  void TakeState(const recording::Message& message) {
    const auto read = vda5050::ReadState(message.payload);
    if (!read) return Tell("a state that cannot be read: " + Shown(read.error().message));
    NoteHeader(message, read->header);
    const bool has_order = !request_.order.empty() && read->order_id == request_.order;
    if (has_order && !taken_) {
      taken_ = now_;
      taken_has_hole_ = had_hole_;
      taken_by_ = Evidence(read->header);
      Tell(fmt::format("taken: a state shows order {}", Shown(request_.order)));
    }
    if (has_order) FollowNodes(*read);
    FollowActions(*read);
    FollowErrors(*read);
    if (has_order) FollowEnd(*read);
    if (!request_.order.empty() && taken_ && !has_order && !is_replaced_) {
      is_replaced_ = true;
      Tell(fmt::format("the robot shows order {} now",
                       Shown(base::NonEmptyOr(read->order_id, "none"))));
    }
    if (read->paused && std::exchange(paused_, *read->paused) != *read->paused) {
      Tell(*read->paused ? "paused" : "no longer paused");
    }
  }

  // Whether a state is missing before this one: the broker may have dropped it.
  void NoteHeader(const recording::Message& message, const vda5050::MessageHeader& header) {
    if (message.retain || message.dup) {
      has_hole_ = true;
      return;
    }
    const bool is_counted = header.header_id && last_id_;
    const bool follows = heard_ && is_counted && *header.header_id == *last_id_ + 1;
    has_hole_ = has_hole_ || !follows;
    if (heard_ && !follows) {
      had_hole_ = true;
      if (is_counted) {
        (*header.header_id <= *last_id_ ? repeated_ : missing_).push_back(Evidence(header));
      }
    }
    if (heard_ && message.t - heard_->t > longest_silence_) {
      longest_silence_ = message.t - heard_->t;
      silence_has_hole_ = has_hole_;
      silent_before_ = Evidence(header);
    }
    heard_ = now_;
    last_id_ = header.header_id;
  }

  void FollowNodes(const RobotState& state) {
    const auto sequence = state.last_node_sequence_id;
    if (!sequence || state.last_node_id.empty()) return;
    if (sequence == last_sequence_) {
      has_hole_ = false;
      return;
    }
    const bool is_first = !last_sequence_;
    if (!is_first && *sequence < *last_sequence_) backward_.push_back(Evidence(state.header));
    if (!is_first && *sequence > *last_sequence_ + 2) {
      (has_hole_ ? perhaps_skipped_ : skipped_).push_back(Evidence(state.header));
    }
    last_sequence_ = sequence;
    has_hole_ = false;
    ++nodes_;
    Tell(fmt::format("node {} (sequenceId {})", Shown(state.last_node_id), *sequence));
  }

  void FollowActions(const RobotState& state) {
    for (const auto* list : {&state.action_states, &state.instant_action_states}) {
      for (const vda5050::ActionState& action : *list) {
        if (!IsOurs(action.id)) continue;
        action_seen_ = true;
        std::string& last = statuses_[action.id];
        if (std::exchange(last, action.status) == action.status) continue;
        Tell(fmt::format("{} ({}) is {}{}", Shown(base::NonEmptyOr(action.type, "action")),
                         Shown(action.id), Shown(action.status),
                         action.result.empty() ? "" : ": " + Shown(action.result)));
        if (action.status != "FAILED") continue;
        const bool is_named = std::any_of(
            state.errors.begin(), state.errors.end(), [&](const vda5050::RobotError& error) {
              return std::any_of(error.references.begin(), error.references.end(),
                                 [&](const auto& one) { return one.value == action.id; });
            });
        (is_named ? explained_ : unexplained_).push_back(Evidence(state.header));
      }
    }
  }

  void FollowErrors(const RobotState& state) {
    std::set<std::string> errors;
    for (const vda5050::RobotError& error : state.errors) {
      const std::string text = fmt::format("{} {}", Shown(error.type), Shown(error.level));
      errors.insert(text);
      if (!errors_.contains(text)) {
        Tell(fmt::format("error {}{}", text,
                         error.description.empty() ? "" : ": " + Shown(error.description)));
      }
      const bool names_order = std::any_of(
          error.references.begin(), error.references.end(),
          [&](const auto& one) { return !request_.order.empty() && one.value == request_.order; });
      if (names_order && order_seen_ && !taken_ && refused_.empty()) {
        refused_ = text;
        taken_by_ = Evidence(state.header);
      }
    }
    for (const std::string& text : errors_) {
      if (!errors.contains(text)) Tell("error " + text + " is over");
    }
    errors_ = std::move(errors);
  }

  void FollowEnd(const RobotState& state) {
    const bool are_ended = std::all_of(
        state.action_states.begin(), state.action_states.end(),
        [](const vda5050::ActionState& action) { return vda5050::IsTerminal(action.status); });
    if (ended_ || state.nodes_left != 0U || state.edges_left.value_or(0) != 0 || !are_ended) return;
    ended_ = now_;
    ended_by_ = Evidence(state.header);
    Tell("nothing of the order is left");
  }

  [[nodiscard]] ExplainFinding CheckTaking() const {
    ExplainFinding finding{.id = "taken", .clause = "6.1.2"};
    if (!order_seen_) {
      finding.text = "the order itself was not heard";
    } else if (!refused_.empty()) {
      finding.verdict = Verdict::kPass;
      finding.text = "the robot refused the order with an error: " + refused_;
      finding.evidence = {taken_by_};
    } else if (taken_) {
      finding.verdict = Verdict::kPass;
      finding.text = "a state shows the order";
      if (!taken_has_hole_) {
        finding.text +=
            " " + Elapsed(std::max(taken_->t - order_seen_->t, microseconds(0))) + " later";
      }
      finding.evidence = {taken_by_};
    } else if (had_hole_ || !heard_ || heard_->t - order_seen_->t < kLongestSilence) {
      finding.text = "no state shows the order, but some are missing, or it ends too soon";
    } else {
      finding.verdict = Verdict::kFail;
      finding.text = "no state shows the order, and no error refuses it";
    }
    return finding;
  }

  [[nodiscard]] ExplainFinding CheckNodes() const {
    ExplainFinding finding{.id = "nodes", .clause = "6.6.2"};
    if (!backward_.empty() || !skipped_.empty()) {
      finding.verdict = Verdict::kFail;
      finding.text = backward_.empty() ? "a node was passed over without a state"
                                       : "lastNodeSequenceId runs backwards";
      finding.evidence = backward_.empty() ? skipped_ : backward_;
    } else if (!perhaps_skipped_.empty()) {
      finding.text = "a node is missing where states are missing, too";
      finding.evidence = perhaps_skipped_;
    } else if (nodes_ < 2) {
      finding.text = "no states show a way from node to node";
    } else {
      finding.verdict = Verdict::kPass;
      finding.text = fmt::format("{} nodes, each in its turn", nodes_);
    }
    return finding;
  }

  [[nodiscard]] ExplainFinding CheckFailures() const {
    ExplainFinding finding{.id = "failures", .clause = "6.6.5"};
    if (!unexplained_.empty()) {
      finding.text =
          "an action is FAILED, and no error names it: right for a cancelled order alone";
      finding.evidence = unexplained_;
    } else if (statuses_.empty()) {
      finding.text = "no state shows an action";
    } else {
      finding.verdict = Verdict::kPass;
      finding.text = explained_.empty() ? "no action failed" : "an error names each failed action";
      finding.evidence = explained_;
    }
    return finding;
  }

  [[nodiscard]] ExplainFinding CheckEnd() const {
    ExplainFinding finding{.id = "end", .clause = "6.6.2, 6.1.2.1"};
    const auto action = statuses_.find(request_.action);
    const bool has_action = action != statuses_.end() && vda5050::IsTerminal(action->second);
    if (request_.action.empty() ? ended_.has_value() : has_action) {
      finding.verdict = Verdict::kPass;
      finding.text = request_.action.empty() ? "the order came to its end"
                                             : "the action ended " + Shown(action->second);
      if (!ended_by_.empty()) finding.evidence = {ended_by_};
    } else {
      finding.text = "no state shows the end";
    }
    return finding;
  }

  [[nodiscard]] ExplainFinding CheckSilence() const {
    ExplainFinding finding{.id = "states", .clause = "6.6 / 6.10"};
    finding.text = "the longest time between two states was " + Elapsed(longest_silence_);
    if (longest_silence_.count() == 0) {
      finding.text = "fewer than two states came";
    } else if (longest_silence_ <= kLongestSilence) {
      finding.verdict = Verdict::kPass;
    } else {
      if (!silence_has_hole_) finding.verdict = Verdict::kFail;
      finding.evidence = {silent_before_};
    }
    return finding;
  }

  [[nodiscard]] ExplainFinding CheckHeaderIds() const {
    ExplainFinding finding{.id = "headerIds", .clause = "7.2 / 6.4"};
    if (!repeated_.empty()) {
      finding.verdict = Verdict::kFail;
      finding.text = "a headerId comes again or runs backwards: two publishers, or a restart";
      finding.evidence = repeated_;
    } else if (!missing_.empty()) {
      finding.text = "headerIds are missing: skipped by the robot, or lost on the way";
      finding.evidence = missing_;
    } else if (last_id_ && longest_silence_.count() > 0) {
      finding.verdict = Verdict::kPass;
      finding.text = "each headerId is the last one plus 1";
    } else {
      finding.text = "fewer than two states with a headerId came";
    }
    return finding;
  }

  const ExplainRequest& request_;
  recording::Moment now_;
  std::vector<TimelineEntry> timeline_;
  std::set<std::string> actions_;  // of the order
  std::optional<recording::Moment> order_seen_;
  std::optional<recording::Moment> taken_;
  std::optional<recording::Moment> ended_;
  std::optional<recording::Moment> heard_;  // the last live state
  bool taken_has_hole_ = false;             // how soon, is not known
  std::string taken_by_;
  std::string refused_;
  std::string ended_by_;
  bool action_seen_ = false;
  bool is_replaced_ = false;
  bool paused_ = false;
  bool has_hole_ = false;  // a state may be missing, since the last that showed no other node
  bool had_hole_ = false;  // anywhere
  std::optional<std::uint32_t> last_id_;
  std::optional<std::uint32_t> last_sequence_;
  std::size_t nodes_ = 0;
  microseconds longest_silence_{0};
  bool silence_has_hole_ = false;
  std::string silent_before_;
  std::map<std::string, std::string> statuses_;  // of actions
  std::set<std::string> errors_;
  std::vector<std::string> missing_;
  std::vector<std::string> repeated_;
  std::vector<std::string> backward_;
  std::vector<std::string> skipped_;
  std::vector<std::string> perhaps_skipped_;
  std::vector<std::string> explained_;
  std::vector<std::string> unexplained_;
};

// What the ledger has of the robot, the newest of it, oldest first; nothing, if it cannot be read.
std::vector<ledger::Record> ReadLedger(const ExplainRequest& request,
                                       const Environment& environment, Log& log) {
  constexpr int kMost = 10'000;
  const auto ledger = environment.ledger(ledger::OpenMode::kReadOnly);
  auto rows = ledger ? (*ledger)->History({.target = request.robot.ToString(), .limit = kMost})
                     : Fail(ledger.error());
  if (rows) return *std::move(rows);
  log.Warn("who sent it is not known: " + rows.error().message);
  return {};
}

bool IsAbout(const ledger::Record& row, const std::string& id) {
  return !id.empty() &&
         std::any_of(row.actions.begin(), row.actions.end(),
                     [&](const message::ActionRef& action) { return action.id == id; });
}

// The id of its order; "": it is of none.
std::string FindOrderId(const ledger::Record& row) {
  for (const message::ActionRef& action : row.actions) {
    if (action.type == "order") return action.id;
  }
  return {};
}

// What was sent from the order on, until another one; of an action that alone.
std::vector<recording::Entry> WhatWasSent(const ExplainRequest& request,
                                          const std::vector<ledger::Record>& rows,
                                          const ListeningPost& post) {
  std::vector<recording::Entry> sent;
  bool is_on = false;
  for (const ledger::Record& row : rows) {
    const bool is_it = IsAbout(row, request.order) || IsAbout(row, request.action);
    if (is_it) is_on = request.action.empty();
    if (!is_it && !FindOrderId(row).empty()) is_on = false;
    if (!is_it && !is_on) continue;
    recording::Message message{post.ToMoment(row.recorded_at)};
    message.topic = row.topic;
    message.payload = row.payload;
    sent.emplace_back(std::move(message));
  }
  return sent;
}

// ---- Telling it ----

// The one that was spoken of last.
Result<std::string> FindLastOrder(const MessageSource& source) {
  std::string last;
  auto read = source({.message =
                          [&](const recording::Message& message, const std::string& topic_name) {
                            if (topic_name != "state" && topic_name != "order") return;
                            const auto document = vda5050::ReadMessage(message.payload);
                            const auto id = document ? base::StringMember(*document, "orderId")
                                                     : std::string_view();
                            if (!id.empty()) last = id;
                          },
                      .event = [](const recording::Event&) {}});
  if (!read) return Fail(std::move(read.error()));
  return last;
}

// Who sent it, and what was heard of it then: that counts where no state shows it.
void AddLedger(const ExplainRequest& request, const std::vector<ledger::Record>& rows,
               Explanation& explanation) {
  for (const ledger::Record& row : rows) {
    if (!IsAbout(row, request.order) && !IsAbout(row, request.action)) continue;
    explanation.timeline.push_back(
        {row.recorded_at,
         fmt::format("sent by {} at {}: {} (fleetpub history show {})", base::Printable(row.user),
                     base::Printable(row.host), row.status, row.id)});
    const bool has_ended = row.status == "FINISHED" || row.status == "FAILED";
    for (ExplainFinding& finding : explanation.findings) {
      const bool is_known = (finding.id == "end" && has_ended) ||
                            (finding.id == "taken" && (has_ended || row.status == "ACCEPTED"));
      if (!is_known || finding.verdict != Verdict::kInconclusive) continue;
      finding.verdict = Verdict::kPass;
      finding.text = fmt::format("the robot's word was heard when it was sent: {}", row.status);
      finding.evidence = {fmt::format("history {}", row.id)};
    }
  }
}

Error NothingKnown(const ExplainRequest& request) {
  const std::string what = !request.order.empty()    ? "order " + Shown(request.order)
                           : !request.action.empty() ? "action " + Shown(request.action)
                                                     : std::string("an order");
  const std::string robot = base::Printable(request.robot.ToString());
  return {ErrorKind::kUnconfirmed,
          request.file.empty()
              ? fmt::format("neither the ledger nor the broker has anything of {} of {}. A "
                            "recording tells more: --from FILE",
                            what, robot)
              : fmt::format("{} has nothing of {} of {}", base::Printable(request.file.string()),
                            what, robot)};
}

}  // namespace

Result<Explanation> Explain(const ExplainRequest& given, const Environment& environment, Log& log) {
  ExplainRequest request = given;
  const auto dialect = ParseDialect(WithConfig(request.vda, environment.config, request.robot));
  if (!dialect) return Fail(dialect.error());
  const vda5050::TopicScheme& scheme = dialect->topics;
  auto rows = ReadLedger(request, environment, log);
  const bool is_live = request.file.empty();
  ListeningPost post(request.robot);
  if (is_live) {
    const auto heard = post.Listen(request.vda, request.listen, environment, log);
    if (!heard) return Fail(heard.error());
    // At another site the robot of that name is another one.
    std::erase_if(rows, [&](const ledger::Record& row) {
      return std::find(post.brokers().begin(), post.brokers().end(), row.broker) ==
             post.brokers().end();
    });
  }
  MessageSource source = is_live ? FromEntries(post.heard(), request.robot, scheme)
                                 : FromRecording(request.file, request.robot, scheme);
  if (request.order.empty() && request.action.empty()) {
    auto order = FindLastOrder(source);
    if (!order) return Fail(std::move(order.error()));
    request.order = *std::move(order);
    for (auto row = rows.rbegin(); is_live && request.order.empty() && row != rows.rend(); ++row) {
      request.order = FindOrderId(*row);
    }
  }
  if (is_live) {
    auto entries = WhatWasSent(request, rows, post);
    entries.emplace_back(post.Gap());
    entries.insert(entries.end(), post.heard().begin(), post.heard().end());
    source = FromEntries(std::move(entries), request.robot, scheme);
  }
  Story story(request);
  auto faults = source({.message = [&](const recording::Message& message,
                                       const std::string& name) { story.Take(message, name); },
                        .event = [&](const recording::Event& event) { story.Take(event); }});
  if (!faults) return Fail(std::move(faults.error()));
  if (story.is_empty()) return Fail(NothingKnown(request));
  Explanation explanation{.order = request.order, .action = request.action};
  explanation.findings = story.Findings();
  explanation.timeline = story.TakeTimeline();
  explanation.faults = *std::move(faults);
  AddLedger(request, rows, explanation);
  std::stable_sort(explanation.timeline.begin(), explanation.timeline.end(),
                   [](const TimelineEntry& a, const TimelineEntry& b) { return a.at < b.at; });
  return explanation;
}

}  // namespace fleetpub::app
