#include "soar/acknowledgement_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>

#include "base/json.h"
#include "base/text.h"
#include "base/time.h"

namespace fleetpub::soar {
namespace {

using base::FindMember;
using base::StringMember;
using message::CommandStatus;
using std::chrono::steady_clock;

class MessageTracker : public message::ResponseTracker {
 public:
  explicit MessageTracker(TrackerOptions options) : options_(std::move(options)) {
    UpdateMessage();
  }

  [[nodiscard]] std::vector<std::string> Topics() const override { return options_.topics; }

  void Published(std::uint32_t /*header_id*/) override { published_ = steady_clock::now(); }

  void Receive(const message::Incoming& message) override {
    if (!published_ || progress_.ended || message.retained) return;
    if (!CanName(message.payload)) return;
    const auto document = base::ParseJsonLeniently(message.payload);
    if (!document) return PassOver(message.payload, document.error());
    const auto said = ReadAcknowledgement(message.topic, *document, options_.prefix);
    if (!said || said->message_id != options_.message_id) return;
    const auto [known, is_new] = levels_.emplace(said->from, said->level);
    if (!is_new && said->level <= known->second) return;
    known->second = said->level;
    Update();
    AddNews(
        fmt::format("{}: {}  {}", base::Printable(base::NonEmptyOr(said->from, options_.target)),
                    GetName(said->level), base::FormatElapsed(steady_clock::now() - *published_)));
  }

  [[nodiscard]] const message::Progress& progress() const override { return progress_; }

 private:
  // A busy backbone brings the acknowledgements of everybody: most need no parsing. JSON may escape
  // any character of an id.
  [[nodiscard]] bool CanName(std::string_view payload) const {
    return payload.find(options_.message_id) != std::string_view::npos ||
           payload.find('\\') != std::string_view::npos;
  }

  // What names our message but cannot be read may be its acknowledgement.
  void PassOver(std::string_view payload, const Error& why) {
    if (payload.find(options_.message_id) == std::string_view::npos) return;
    ++unreadable_;
    why_ = why.message;
    progress_.unreadable = true;
    UpdateMessage();
  }

  [[nodiscard]] std::size_t Count(Level level) const {
    return static_cast<std::size_t>(std::count_if(
        levels_.begin(), levels_.end(), [&](const auto& one) { return one.second >= level; }));
  }

  void Update() {
    progress_.seen = true;
    UpdateMessage();
    if (Count(options_.wait_for) < options_.count) return;
    progress_.ended = true;
    const bool done = Count(Level::kExecuted) >= options_.count;
    progress_.status = done ? CommandStatus::kFinished : CommandStatus::kAccepted;
  }

  void UpdateMessage() {
    progress_.message = levels_.empty() ? "nobody acknowledged it" : FormatLevels();
    if (unreadable_ == 0) return;
    progress_.message += fmt::format("; {} that name it cannot be read, the last one: {}",
                                     base::Counted(unreadable_, "message"), why_);
  }

  // `executed`; of several: `2 of 3 executed`.
  [[nodiscard]] std::string FormatLevels() const {
    if (options_.count == 1) {
      const auto highest =
          std::max_element(levels_.begin(), levels_.end(),
                           [](const auto& a, const auto& b) { return a.second < b.second; });
      return std::string(GetName(highest->second));
    }
    std::vector<std::string> parts;
    for (const auto& [name, level] : kLevels) {
      if (Count(level) == 0 || level > options_.wait_for) continue;
      parts.push_back(fmt::format("{} of {} {}", Count(level), options_.count, name));
    }
    return base::Join(parts, ", ");
  }

  TrackerOptions options_;
  std::optional<steady_clock::time_point> published_;
  message::Progress progress_;
  std::map<std::string, Level> levels_;  // by who said it
  int unreadable_ = 0;
  std::string why_;
};

std::string FormatSource(std::string_view topic, std::string_view source, const Prefix& prefix) {
  if (const auto platform = FindPlatform(topic, prefix)) {
    std::string name = prefix.Dotted() + "." + platform->Topic();
    std::replace(name.begin(), name.end(), '/', '.');
    return name;
  }
  return std::string(source);
}

}  // namespace

std::optional<Acknowledgement> ReadAcknowledgement(std::string_view topic,
                                                   const base::JsonValue& message,
                                                   const Prefix& prefix) {
  const auto* said = FindMember(message, "payload");
  if (said == nullptr ||
      StringMember(*said, "message_type") != GetName(MessageType::kAcknowledgement)) {
    return std::nullopt;
  }
  const auto level = ParseLevel(StringMember(*said, "status"));
  if (!level) return std::nullopt;
  const auto* header = FindMember(message, "header");
  const auto source = header == nullptr ? std::string_view() : StringMember(*header, "source");
  return Acknowledgement{std::string(StringMember(*said, "acknowledged_message_ID")), *level,
                         FormatSource(topic, source, prefix)};
}

std::unique_ptr<message::ResponseTracker> TrackAcknowledgements(TrackerOptions options) {
  return std::make_unique<MessageTracker>(std::move(options));
}

}  // namespace fleetpub::soar
