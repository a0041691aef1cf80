#include "delivery/pending_commands.h"

#include <algorithm>

#include "delivery/topic_filter.h"

namespace fleetpub::delivery {

PendingCommands::PendingCommands(const WaitOptions& options, EndHook ended, NewsHook news, Now now)
    : options_(options), ended_(std::move(ended)), news_(std::move(news)), now_(std::move(now)) {}

PendingCommands::KeysByTopic& PendingCommands::MapFor(const std::string& topic) {
  return HasWildcard(topic) ? by_filter_ : by_topic_;
}

void PendingCommands::Track(Key key, std::shared_ptr<message::ResponseTracker> tracker) {
  for (const std::string& topic : tracker->Topics()) MapFor(topic)[topic].insert(key);
  tracked_[key].tracker = std::move(tracker);
}

void PendingCommands::Forget(Key key) {
  const auto found = tracked_.find(key);
  if (found == tracked_.end()) return;
  for (const std::string& topic : found->second.tracker->Topics()) {
    KeysByTopic& map = MapFor(topic);
    const auto keys = map.find(topic);
    if (keys == map.end()) continue;
    keys->second.erase(key);
    if (keys->second.empty()) map.erase(keys);
  }
  limits_.erase({found->second.limit, key});
  if (found->second.open) --waiting_;
  tracked_.erase(found);
}

std::vector<std::string> PendingCommands::Topics() const {
  std::vector<std::string> topics;
  topics.reserve(by_topic_.size() + by_filter_.size());
  for (const auto& [topic, keys] : by_topic_) topics.push_back(topic);
  for (const auto& [filter, keys] : by_filter_) topics.push_back(filter);
  return topics;
}

std::chrono::milliseconds PendingCommands::PatienceToBeSeen() const {
  return options_.total ? *options_.total / (options_.resend + 1) : options_.seen;
}

void PendingCommands::Published(Key key, message::Report report) {
  const auto found = tracked_.find(key);
  if (found == tracked_.end()) return;
  Tracked& watched = found->second;
  const auto now = now_();
  if (!watched.open) {
    watched.open = true;
    watched.published = now;
    watched.started = now - report.elapsed;
    ++waiting_;
  }
  SetLimitToBeSeen(*found, now);
  watched.tracker->Published(report.header_id.value_or(0));
  watched.report = std::move(report);
  TellNews(*watched.tracker);                             // of what the target said before
  if (watched.tracker->progress().ended) Update(*found);  // of whom no answer is expected
}

void PendingCommands::SetLimitToBeSeen(Entry& entry, Clock::time_point now) {
  auto limit = now + PatienceToBeSeen();
  if (options_.total) limit = std::min(limit, entry.second.published + *options_.total);
  SetLimit(entry, limit);
}

void PendingCommands::SetLimit(Entry& entry, Clock::time_point limit) {
  limits_.erase({entry.second.limit, entry.first});
  entry.second.limit = limit;
  limits_.emplace(limit, entry.first);
}

void PendingCommands::Deliver(const mqtt::Message& message) {
  // Who ends is taken out of the maps.
  std::vector<Key> keys;
  const auto exact = by_topic_.find(message.topic);
  if (exact != by_topic_.end()) keys.assign(exact->second.begin(), exact->second.end());
  for (const auto& [filter, listeners] : by_filter_) {
    if (Matches(filter, message.topic)) keys.insert(keys.end(), listeners.begin(), listeners.end());
  }
  for (const Key key : keys) {
    const auto found = tracked_.find(key);
    if (found == tracked_.end()) continue;
    found->second.tracker->Receive({message.topic, message.payload, message.retained});
    if (found->second.open) Update(*found);
  }
}

void PendingCommands::Update(Entry& entry) {
  Tracked& watched = entry.second;
  TellNews(*watched.tracker);
  const message::Progress& progress = watched.tracker->progress();
  if (progress.ended) {
    return End(entry, progress.status, message::ToErrorKind(progress.status), progress.message);
  }
  if (progress.seen && !watched.seen) {
    watched.seen = true;
    SetLimit(entry, options_.total ? watched.published + *options_.total : now_() + options_.done);
  }
}

void PendingCommands::TellNews(message::ResponseTracker& tracker) const {
  for (const std::string& line : tracker.TakeNews()) {
    if (news_) news_(line);
  }
}

void PendingCommands::End(Entry& entry, message::CommandStatus status,
                          std::optional<ErrorKind> error, std::string message) {
  message::Report report = std::move(entry.second.report);
  report.status = status;
  report.error = error;
  report.message = std::move(message);
  report.kept = entry.second.tracker->progress().kept;
  if (error && report.unacknowledged) report.message += "; the broker did not acknowledge it";
  report.elapsed = now_() - entry.second.started;
  const Key key = entry.first;
  Forget(key);
  ended_(key, std::move(report));
}

std::vector<PendingCommands::Key> PendingCommands::Expire() {
  std::vector<Key> again;
  const auto now = now_();
  while (!limits_.empty() && limits_.begin()->first <= now) {
    Entry& entry = *tracked_.find(limits_.begin()->second);
    Tracked& watched = entry.second;
    const message::Progress& progress = watched.tracker->progress();
    // Not when the whole time is up, however late that is noticed.
    const bool in_time = !options_.total || now < watched.published + *options_.total;
    const bool may_repeat = in_time && !watched.seen && watched.repeats < options_.resend;
    if (may_repeat && progress.unreadable) {  // its answer, perhaps
      watched.repeats = options_.resend;
      SetLimit(entry, watched.published + options_.total.value_or(options_.seen));
    } else if (may_repeat) {
      ++watched.repeats;
      // Should it not leave, it is not repeated at once.
      SetLimitToBeSeen(entry, now);
      again.push_back(entry.first);
    } else {
      End(entry, message::CommandStatus::kTimeout,
          message::ToErrorKind(message::CommandStatus::kTimeout), progress.message);
    }
  }
  std::sort(again.begin(), again.end());
  return again;
}

void PendingCommands::EndAll(message::CommandStatus status, const Error& reason) {
  while (!limits_.empty()) {
    Entry& entry = *tracked_.find(limits_.begin()->second);
    const std::string& said = entry.second.tracker->progress().message;
    End(entry, status, reason.kind, reason.message + (said.empty() ? "" : "; " + said));
  }
}

Waiting PendingCommands::DescribeWaiting() const {
  if (limits_.empty()) return {};
  const Tracked& next = tracked_.find(limits_.begin()->second)->second;
  return {.commands = waiting_,
          .target = next.report.target,
          .seen = next.seen,
          .message = next.tracker->progress().message,
          .published = next.published,
          .limit = next.limit};
}

PendingCommands::Clock::time_point PendingCommands::NextLimit() const {
  return limits_.empty() ? Clock::time_point::max() : limits_.begin()->first;
}

}  // namespace fleetpub::delivery
