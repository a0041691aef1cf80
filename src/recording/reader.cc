#include "recording/reader.h"

#include <fmt/format.h>

#include <utility>

#include "base/text.h"

namespace fleetpub::recording {
namespace {

const Moment& When(const Entry& entry, const Moment& otherwise) {
  if (const auto* message = std::get_if<Message>(&entry)) return *message;
  if (const auto* event = std::get_if<Event>(&entry)) return *event;
  return otherwise;
}

}  // namespace

std::filesystem::path PartPath(const std::filesystem::path& path, int part) {
  const std::string name = path.filename().string();
  const std::size_t dot = std::min(name.find('.', 1), name.size());
  return path.parent_path() /
         fmt::format("{}.{:04}{}", name.substr(0, dot), part, name.substr(dot));
}

Reader::Reader(std::deque<std::filesystem::path> parts, InputFile file)
    : parts_(std::move(parts)), file_(std::move(file)) {}

Result<Reader> Reader::Open(const std::filesystem::path& path) {
  std::deque<std::filesystem::path> parts = {path};
  std::error_code ignored;
  if (path != "-" && !std::filesystem::exists(path, ignored)) {
    parts.clear();
    for (int i = 1; std::filesystem::exists(PartPath(path, i), ignored); ++i) {
      parts.push_back(PartPath(path, i));
    }
    if (parts.empty()) parts.push_back(path);
  }
  auto file = InputFile::Open(parts.front());
  if (!file) return Fail(std::move(file.error()));
  return Reader(std::move(parts), *std::move(file));
}

void Reader::Note(const Error& error) {
  ++faults_.unreadable;
  if (!faults_.first.empty()) return;
  faults_.first = fmt::format("{}:{}: {}", base::Printable(parts_.front().string()), line_,
                              base::Printable(error.message));
}

void Reader::EndFile() {
  faults_.is_cut_off = faults_.is_cut_off || is_torn_ || (has_head_ && !has_foot_);
  if (!row_.empty()) Note({ErrorKind::kInvalid, "the row has no end"});
  row_.clear();
  has_head_ = has_foot_ = is_torn_ = false;
  line_ = count_ = 0;
  sum_.Restart();
}

Result<std::optional<Entry>> Reader::Next() {
  for (;;) {
    const auto line = file_.Next();
    ++line_;
    if (!line && line.error().kind != ErrorKind::kInvalid) return Fail(line.error());
    if (!line) {
      Note(line.error());
      continue;
    }
    if (!*line) {
      EndFile();
      parts_.pop_front();
      if (parts_.empty()) break;
      auto next = InputFile::Open(parts_.front());
      if (!next) return Fail(std::move(next.error()));
      file_ = *std::move(next);
      continue;
    }
    auto entry = Parse(**line);
    if (!entry) {
      // What a crash has cut off is no fault of its own.
      is_torn_ = file_.is_cut_off();
      if (!is_torn_) Note(entry.error());
      continue;
    }
    if (!*entry) continue;
    ++entries_;
    last_ = When(**entry, last_);
    return entry;
  }
  parts_.emplace_back();  // Next() may be called again
  if (entries_ == 0 && faults_.unreadable > 0) {
    return Fail(ErrorKind::kInvalid, "it is no recording: " + faults_.first);
  }
  return std::optional<Entry>();
}

Result<std::optional<Entry>> Reader::Parse(std::string_view line) {
  if (row_.empty() && base::Trimmed(line).empty()) return std::nullopt;
  if (row_.empty() && base::Trimmed(line).starts_with('{')) {
    auto entry = ParseJsonLine(line, last_);
    if (!entry || !*entry) return entry;
    if (auto* message = std::get_if<Message>(&**entry)) {
      ++count_;
      // The first one that says no t is where time begins.
      if (!std::exchange(start_, start_.value_or(message->at)) && !has_head_ &&
          line.find("\"t\":") == std::string_view::npos) {
        message->t = std::chrono::microseconds(0);
      }
    } else if (std::get_if<Head>(&**entry) != nullptr) {
      has_head_ = true;
      if (last_.at == base::WallTime()) last_.at = std::get<Head>(**entry).started;
    } else if (const auto* foot = std::get_if<Foot>(&**entry)) {
      has_foot_ = true;
      const bool is_same = foot->count == count_ && foot->sha256 == sum_.Digest();
      faults_.is_altered = faults_.is_altered || !is_same;
    }
    sum_.Add(line);
    sum_.Add("\n");
    return entry;
  }
  row_ += line;
  if (IsOpenRow(row_) && row_.size() < InputFile::kLongestLine) {
    row_ += '\n';
    return std::nullopt;
  }
  auto message = ParseCsvRow(std::exchange(row_, {}));
  if (!message) return Fail(std::move(message.error()));
  ++count_;
  start_ = start_.value_or(message->at);
  message->t = std::max(
      last_.t, std::chrono::duration_cast<std::chrono::microseconds>(message->at - *start_));
  return *std::move(message);
}

Result<std::optional<Message>> Reader::NextMessage() {
  for (;;) {
    auto entry = Next();
    if (!entry) return Fail(std::move(entry.error()));
    if (!*entry) return std::nullopt;
    if (auto* message = std::get_if<Message>(&**entry)) return std::move(*message);
  }
}

}  // namespace fleetpub::recording
