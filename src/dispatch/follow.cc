#include "dispatch/follow.h"

#include <algorithm>

#include "dispatch/topic_filter.h"

namespace fleetpub::dispatch {

Follower::Follower(const WaitOptions& options, EndHook ended)
    : options_(options), ended_(std::move(ended)) {}

Follower::KeysByTopic& Follower::MapFor(const std::string& topic) {
  return HasWildcard(topic) ? by_filter_ : by_topic_;
}

void Follower::Watch(Key key, std::shared_ptr<Confirmation> confirmation) {
  for (const std::string& topic : confirmation->Topics()) MapFor(topic)[topic].insert(key);
  watched_[key].confirmation = std::move(confirmation);
}

void Follower::Forget(Key key) {
  const auto found = watched_.find(key);
  if (found == watched_.end()) return;
  for (const std::string& topic : found->second.confirmation->Topics()) {
    KeysByTopic& map = MapFor(topic);
    const auto keys = map.find(topic);
    if (keys == map.end()) continue;
    keys->second.erase(key);
    if (keys->second.empty()) map.erase(keys);
  }
  limits_.erase({found->second.limit, key});
  if (found->second.open) --waiting_;
  watched_.erase(found);
}

std::vector<std::string> Follower::Topics() const {
  std::vector<std::string> topics;
  topics.reserve(by_topic_.size() + by_filter_.size());
  for (const auto& [topic, keys] : by_topic_) topics.push_back(topic);
  for (const auto& [filter, keys] : by_filter_) topics.push_back(filter);
  return topics;
}

std::chrono::milliseconds Follower::PatienceToBeSeen() const {
  return options_.total ? *options_.total / (options_.resend + 1) : options_.seen;
}

void Follower::Published(Key key, Report report) {
  const auto found = watched_.find(key);
  if (found == watched_.end()) return;
  Watched& watched = found->second;
  const auto now = Clock::now();
  if (!watched.open) {
    watched.open = true;
    watched.published = now;
    ++waiting_;
  }
  SetLimit(*found, now + PatienceToBeSeen());
  watched.confirmation->Published(report.header_id.value_or(0));
  watched.report = std::move(report);
  if (watched.confirmation->progress().ended) Look(*found);  // of whom no answer is expected
}

void Follower::SetLimit(Entry& entry, Clock::time_point limit) {
  limits_.erase({entry.second.limit, entry.first});
  entry.second.limit = limit;
  limits_.emplace(limit, entry.first);
}

void Follower::Deliver(const mqtt::Message& message) {
  // Who ends is taken out of the maps.
  std::vector<Key> keys;
  const auto exact = by_topic_.find(message.topic);
  if (exact != by_topic_.end()) keys.assign(exact->second.begin(), exact->second.end());
  for (const auto& [filter, listeners] : by_filter_) {
    if (Matches(filter, message.topic)) keys.insert(keys.end(), listeners.begin(), listeners.end());
  }
  for (const Key key : keys) {
    const auto found = watched_.find(key);
    if (found == watched_.end()) continue;
    found->second.confirmation->Receive({message.topic, message.payload, message.retained});
    if (found->second.open) Look(*found);
  }
}

void Follower::Look(Entry& entry) {
  Watched& watched = entry.second;
  const Progress& progress = watched.confirmation->progress();
  if (progress.ended) {
    return End(entry, progress.verdict, TroubleOf(progress.verdict), progress.message);
  }
  if (progress.seen && !watched.seen) {
    watched.seen = true;
    SetLimit(entry,
             options_.total ? watched.published + *options_.total : Clock::now() + options_.done);
  }
}

void Follower::End(Entry& entry, Verdict verdict, std::optional<ErrorKind> error,
                   std::string message) {
  Report report = std::move(entry.second.report);
  report.verdict = verdict;
  report.error = error;
  report.message = std::move(message);
  report.elapsed = Clock::now() - entry.second.published;
  const Key key = entry.first;
  Forget(key);
  ended_(key, std::move(report));
}

std::vector<Follower::Key> Follower::Expire() {
  std::vector<Key> again;
  const auto now = Clock::now();
  while (!limits_.empty() && limits_.begin()->first <= now) {
    Entry& entry = *watched_.find(limits_.begin()->second);
    Watched& watched = entry.second;
    if (!watched.seen && watched.repeats < options_.resend) {
      ++watched.repeats;
      // Should it not leave, it is not repeated at once.
      SetLimit(entry, now + PatienceToBeSeen());
      again.push_back(entry.first);
    } else {
      End(entry, Verdict::kTimeout, TroubleOf(Verdict::kTimeout),
          watched.confirmation->progress().message);
    }
  }
  std::sort(again.begin(), again.end());
  return again;
}

void Follower::EndAll(const Error& reason) {
  while (!limits_.empty()) {
    End(*watched_.find(limits_.begin()->second), Verdict::kError, reason.kind, reason.message);
  }
}

Follower::Clock::time_point Follower::NextLimit() const {
  return limits_.empty() ? Clock::time_point::max() : limits_.begin()->first;
}

}  // namespace fleetpub::dispatch
