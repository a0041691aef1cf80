#include "dispatch/follow.h"

#include <algorithm>

#include "dispatch/topic_filter.h"

namespace fleetpub::dispatch {

Follower::Follower(const WaitOptions& options, EndHook ended)
    : options_(options), ended_(std::move(ended)) {}

void Follower::Watch(std::size_t index, Confirmation* confirmation) {
  watched_[index].confirmation = confirmation;
  for (const std::string& topic : confirmation->Topics()) {
    auto& indices = HasWildcard(topic) ? by_filter_[topic] : by_topic_[topic];
    indices.push_back(index);
  }
}

std::vector<std::string> Follower::Topics() const {
  std::vector<std::string> topics;
  topics.reserve(by_topic_.size() + by_filter_.size());
  for (const auto& [topic, indices] : by_topic_) topics.push_back(topic);
  for (const auto& [filter, indices] : by_filter_) topics.push_back(filter);
  return topics;
}

std::chrono::milliseconds Follower::PatienceToBeSeen() const {
  return options_.total ? *options_.total / (options_.resend + 1) : options_.seen;
}

void Follower::Published(std::size_t index, Report report) {
  Watched& watched = watched_.at(index);
  const auto now = Clock::now();
  if (!watched.open) {
    watched.open = true;
    watched.published = now;
    ++waiting_;
  }
  watched.limit = now + PatienceToBeSeen();
  watched.confirmation->Published(report.header_id.value_or(0));
  watched.report = std::move(report);
}

void Follower::Deliver(const mqtt::Message& message) {
  const auto found = by_topic_.find(message.topic);
  if (found != by_topic_.end()) DeliverTo(found->second, message);
  for (const auto& [filter, indices] : by_filter_) {
    if (Matches(filter, message.topic)) DeliverTo(indices, message);
  }
}

void Follower::DeliverTo(const std::vector<std::size_t>& indices, const mqtt::Message& message) {
  for (const std::size_t index : indices) {
    Watched& watched = watched_.at(index);
    watched.confirmation->Receive({message.topic, message.payload, message.retained});
    if (watched.open) Look(watched);
  }
}

void Follower::Look(Watched& watched) {
  const Progress& progress = watched.confirmation->progress();
  if (progress.ended) return End(watched, progress.verdict, progress.message);
  if (progress.seen && !watched.seen) {
    watched.seen = true;
    watched.limit =
        options_.total ? watched.published + *options_.total : Clock::now() + options_.done;
  }
}

void Follower::End(Watched& watched, Verdict verdict, const std::string& message) {
  watched.open = false;
  --waiting_;
  watched.report.verdict = verdict;
  watched.report.error = TroubleOf(verdict);
  watched.report.message = message;
  watched.report.elapsed = Clock::now() - watched.published;
  ended_(watched.report);
}

std::vector<std::size_t> Follower::Expire() {
  std::vector<std::size_t> again;
  const auto now = Clock::now();
  for (auto& [index, watched] : watched_) {
    if (!watched.open || now < watched.limit) continue;
    if (!watched.seen && watched.repeats < options_.resend) {
      ++watched.repeats;
      again.push_back(index);
    } else {
      End(watched, Verdict::kTimeout, watched.confirmation->progress().message);
    }
  }
  std::sort(again.begin(), again.end());
  return again;
}

Follower::Clock::time_point Follower::NextLimit() const {
  auto next = Clock::time_point::max();
  for (const auto& [index, watched] : watched_) {
    if (watched.open) next = std::min(next, watched.limit);
  }
  return next;
}

}  // namespace fleetpub::dispatch
