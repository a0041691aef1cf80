#include "delivery/played_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "base/text.h"
#include "delivery/topic_filter.h"

namespace fleetpub::delivery {

using recording::Faults;

namespace {

Error NoSending() {
  return {ErrorKind::kUsage, "nothing is sent to a recording: leave --from out"};
}

// What a broker would have kept, whether or not it said so.
bool IsKept(const recording::Message& message) {
  return message.retain || message.topic.ends_with("/connection") ||
         message.topic.ends_with("/factsheet");
}

}  // namespace

class RecordingTransport final : public mqtt::Transport {
 public:
  explicit RecordingTransport(PlayedRecording& recording) : recording_(recording) {
    server_.broker.host = recording.name();
  }

  [[nodiscard]] const mqtt::ServerInfo& server() const override { return server_; }

  [[nodiscard]] Status Subscribe(std::span<const std::string> filters, mqtt::Qos /*qos*/,
                                 mqtt::Deadline /*deadline*/) override {
    filters_.assign(filters.begin(), filters.end());
    matches_.clear();
    if (recording_.play_ == Play::kLast) return HandOutLast();
    return std::exchange(is_fresh_, false) ? Status() : Begin();
  }

  [[nodiscard]] Status Unsubscribe(std::span<const std::string> /*filters*/,
                                   mqtt::Deadline /*deadline*/) override {
    return {};
  }

  [[nodiscard]] Result<std::optional<mqtt::Message>> Receive(mqtt::Deadline /*deadline*/) override {
    if (recording_.play_ == Play::kLast) {
      if (last_.empty()) return std::nullopt;
      mqtt::Message message = ToMqtt(*last_.front(), IsKept(*last_.front()));
      last_.pop_front();
      return message;
    }
    while (reader_) {
      const auto message = Read();
      if (message && IsMatch(message->topic)) return ToMqtt(*message, message->retain);
    }
    return std::nullopt;
  }

  [[nodiscard]] bool HasEnded() const override { return last_.empty() && !reader_; }

  [[nodiscard]] Status Admits(const std::string& /*topic*/, std::size_t /*size*/,
                              mqtt::Qos /*qos*/) const override {
    return Fail(NoSending());
  }
  [[nodiscard]] Status AwaitReady(mqtt::Deadline /*deadline*/) override {
    return Fail(NoSending());
  }
  [[nodiscard]] Result<int> Publish(const mqtt::Message& /*message*/,
                                    mqtt::Deadline /*deadline*/) override {
    return Fail(NoSending());
  }
  void Cork(bool /*on*/) override {}
  [[nodiscard]] Result<std::vector<mqtt::Acknowledgement>> AwaitAcknowledgements(
      mqtt::Deadline /*deadline*/, std::size_t /*left*/) override {
    return std::vector<mqtt::Acknowledgement>();
  }
  [[nodiscard]] int in_flight() const override { return 0; }
  void WakeOn(std::span<const int> /*descriptors*/) override {}
  void Disconnect() override {}

  /// For who subscribes first.
  Status Prepare() {
    is_fresh_ = true;
    return Begin();
  }

 private:
  // To the first message: what is no recording is told at once. Of Play::kLast, all of it.
  Status Begin() {
    if (recording_.path_ == "-" && std::exchange(recording_.is_read_, true)) {
      return Fail(ErrorKind::kUsage,
                  "this reads its recording twice, and standard input once only: name a file");
    }
    auto reader = recording::Reader::Open(recording_.path_);
    auto first = reader ? reader->NextMessage() : Fail(std::move(reader.error()));
    if (!first) return Fail(std::move(first.error()));
    reader_ = *std::move(reader);
    first_ = *std::move(first);
    if (recording_.play_ == Play::kAll) return {};
    while (reader_) {
      const auto message = Read();
      if (!message) break;
      order_[message->topic] = ++count_;
      topics_[message->topic] = *message;
    }
    return recording_.trouble_ ? Status(Fail(*recording_.trouble_)) : Status();
  }

  // What cannot be read further has ended.
  std::optional<recording::Message> Read() {
    auto message = first_ ? Result<std::optional<recording::Message>>(std::exchange(first_, {}))
                          : reader_->NextMessage();
    if (!message) recording_.trouble_ = message.error();
    if (message && *message) {
      recording_.now_ = (*message)->at;
      recording_.elapsed_ = (*message)->t;
      return *std::move(message);
    }
    recording_.faults_ = reader_->faults();
    reader_.reset();
    return std::nullopt;
  }

  Status HandOutLast() {
    std::map<std::size_t, const recording::Message*> found;
    const auto take = [&](const auto& kept) { found[order_.at(kept.first)] = &kept.second; };
    // Thousands of robots are asked for by name: those are not compared with each topic.
    std::erase_if(filters_, [&](const std::string& filter) {
      if (HasWildcard(filter)) return false;
      if (const auto kept = topics_.find(filter); kept != topics_.end()) take(*kept);
      return true;
    });
    for (const auto& kept : topics_) {
      if (!filters_.empty() && IsMatch(kept.first)) take(kept);
    }
    last_.clear();
    for (const auto& [place, message] : found) last_.push_back(message);
    return {};
  }

  // Topics are few beside messages.
  bool IsMatch(const std::string& topic) {
    const auto [known, is_new] = matches_.try_emplace(topic, false);
    if (is_new) {
      known->second = std::any_of(filters_.begin(), filters_.end(),
                                  [&](const auto& filter) { return Matches(filter, topic); });
    }
    return known->second;
  }

  static mqtt::Message ToMqtt(const recording::Message& message, bool retained) {
    return {.topic = message.topic,
            .payload = message.payload,
            .qos = static_cast<mqtt::Qos>(message.qos),
            .retained = retained,
            .duplicate = message.dup};
  }

  PlayedRecording& recording_;
  mqtt::ServerInfo server_;
  std::vector<std::string> filters_;
  std::map<std::string, bool> matches_;  // by topic
  std::optional<recording::Reader> reader_;
  std::optional<recording::Message> first_;           // read, and not handed out
  bool is_fresh_ = false;                             // nobody has subscribed
  std::map<std::string, recording::Message> topics_;  // the last of each
  std::map<std::string, std::size_t> order_;
  std::size_t count_ = 0;
  std::deque<const recording::Message*> last_;  // to be handed out
};

PlayedRecording::PlayedRecording(std::filesystem::path path, Play play)
    : path_(std::move(path)), play_(play) {}

Result<std::unique_ptr<mqtt::Transport>> PlayedRecording::Open() {
  auto transport = std::make_unique<RecordingTransport>(*this);
  if (auto ok = transport->Prepare(); !ok) return Fail(std::move(ok.error()));
  return transport;
}

std::string PlayedRecording::Complaint() const {
  std::vector<std::string> texts;
  if (trouble_) texts.push_back(trouble_->message);
  if (faults_.is_cut_off) texts.emplace_back("it has no end: whoever wrote it was cut off");
  if (faults_.is_altered) texts.emplace_back("it is not what its last line says: it was changed");
  if (faults_.unreadable > 0) {
    texts.push_back(fmt::format("{} could not be read, the first at {}",
                                base::Counted(faults_.unreadable, "line"), faults_.first));
  }
  if (texts.empty()) return "";
  return base::Printable(name()) + ": " + base::Join(texts, "; ");
}

}  // namespace fleetpub::delivery
