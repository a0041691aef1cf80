// A ledger in memory, through the production interface. It can be told to refuse.
#pragma once

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include "ledger/ledger.h"
#include "support/journal.h"

namespace fleetpub::testing {

/// Notes `lock TOPIC…`, `reserve N`, `unlock` and `record STATUS…` in the journal. Reserving
/// without the lock is a bug of the caller and throws.
class FakeLedger : public ledger::Ledger {
 public:
  explicit FakeLedger(Journal& journal) : journal_(journal) {}

  // What the next calls are answered with, when it is set.
  std::optional<Error> lock_error;
  std::optional<Error> reserve_error;
  std::optional<Error> record_error;
  int reserve_errors_begin_at = 0;  ///< so many calls of Reserve succeed before
  /// A lock is still held so often that it is asked for.
  int held_so_often = std::numeric_limits<int>::max();

  [[nodiscard]] const std::vector<ledger::Record>& rows() const { return rows_; }
  [[nodiscard]] ledger::Deadline last_deadline() const { return last_deadline_; }

  Result<std::unique_ptr<ledger::TopicLock>> Lock(std::span<const std::string> topics,
                                                  ledger::Deadline deadline) override {
    last_deadline_ = deadline;
    if (lock_error) return Fail(*lock_error);
    for (const std::string& topic : topics) {
      if (locked_.contains(topic)) return Fail(ErrorKind::kLedger, topic + " is held");
    }
    journal_.Record("lock", topics);
    locked_.insert(topics.begin(), topics.end());
    return std::make_unique<Held>(*this, topics);
  }

  Result<std::vector<ledger::Reservation>> Reserve(std::span<const ledger::Draft> drafts) override {
    if (reserve_error && reserve_calls_++ >= reserve_errors_begin_at) return Fail(*reserve_error);
    journal_.Record("reserve " + std::to_string(drafts.size()));
    std::vector<ledger::Reservation> reservations;
    for (const ledger::Draft& draft : drafts) reservations.push_back(Record(draft));
    return reservations;
  }

  Status RecordOutcomes(std::span<const ledger::StatusUpdate> outcomes) override {
    std::vector<std::string> statuses;
    for (const ledger::StatusUpdate& outcome : outcomes) statuses.push_back(outcome.status);
    journal_.Record("record", statuses);
    if (record_error) return Fail(*record_error);
    for (const auto& [row, status, detail] : outcomes) {
      ledger::Record& record = rows_.at(static_cast<std::size_t>(row - 1));
      record.status = status;
      record.detail = detail;
    }
    return {};
  }

  Result<std::uint32_t> Peek(const ledger::Draft& draft) override {
    const auto found = next_ids_.find(draft.topic);
    return found == next_ids_.end() ? 0 : found->second;
  }
  Result<std::vector<ledger::Record>> History(const ledger::HistoryFilter& filter) override {
    std::vector<ledger::Record> rows = rows_;
    std::erase_if(rows, [&](const ledger::Record& row) {
      return !filter.brokers.empty() && std::find(filter.brokers.begin(), filter.brokers.end(),
                                                  row.broker) == filter.brokers.end();
    });
    return rows;
  }
  Result<std::optional<ledger::Record>> Find(std::int64_t id) override {
    if (id < 1 || id > std::ssize(rows_)) return std::optional<ledger::Record>();
    return rows_[static_cast<std::size_t>(id - 1)];
  }
  Result<std::int64_t> Prune(ledger::WallTime /*older_than*/) override { return 0; }
  Result<ledger::LedgerInfo> Describe() override { return ledger::LedgerInfo{.kind = "fake"}; }

 private:
  class Held : public ledger::TopicLock {
   public:
    Held(FakeLedger& ledger, std::span<const std::string> topics)
        : ledger_(ledger), topics_(topics.begin(), topics.end()) {}
    Held(const Held&) = delete;
    Held& operator=(const Held&) = delete;
    ~Held() override {
      for (const std::string& topic : topics_) ledger_.locked_.erase(topic);
      ledger_.journal_.Record("unlock");
    }
    [[nodiscard]] bool StillHeld() const override { return --ledger_.held_so_often >= 0; }

   private:
    FakeLedger& ledger_;
    std::vector<std::string> topics_;
  };

  ledger::Reservation Record(const ledger::Draft& draft) {
    if (!locked_.contains(draft.topic)) throw std::logic_error("not locked: " + draft.topic);
    std::uint32_t& next = next_ids_[draft.topic];
    const std::uint32_t id = draft.header_id.value_or(next);
    if (draft.counted) next = id + 1;
    ledger::Record record;
    record.id = std::ssize(rows_) + 1;
    record.broker = draft.broker;
    record.target = draft.target;
    record.protocol = draft.protocol;
    record.version = draft.version;
    record.topic = draft.topic;
    if (draft.counted) record.header_id = id;
    record.actions = draft.actions;
    record.payload = ledger::BuildPayload(draft, id);
    record.status = "RECORDED";
    rows_.push_back(record);
    return {record.id, id};
  }

  Journal& journal_;
  std::set<std::string> locked_;
  std::map<std::string, std::uint32_t> next_ids_;
  std::vector<ledger::Record> rows_;
  ledger::Deadline last_deadline_;
  int reserve_calls_ = 0;
};

}  // namespace fleetpub::testing
