#include "recording/entry.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/json.h"
#include "base/text.h"
#include "recording/bytes.h"

namespace fleetpub::recording {
namespace {

using base::FindMember;
using base::JsonString;
using base::JsonValue;
using base::StringMember;
using std::chrono::microseconds;

std::string Seconds(microseconds time) {
  return fmt::format("{}.{:06}", time.count() / 1'000'000, time.count() % 1'000'000);
}

// `timestamp` is what others call `at`.
std::string When(const Moment& moment) {
  return fmt::format(R"("t":{},"at":"{}")", Seconds(moment.t), base::FormatTimestamp(moment.at));
}

std::optional<microseconds> ReadSeconds(const JsonValue* value) {
  constexpr double kMost = 1e12;
  if (value == nullptr || !value->IsNumber()) return std::nullopt;
  const double seconds = value->GetDouble();
  if (!(std::abs(seconds) < kMost)) return std::nullopt;
  return microseconds(std::llround(std::max(seconds, 0.0) * 1e6));
}

// Also `2026-01-02T03:04:05.330735Z+0000`, which mosquitto_sub 2.0.11 writes, and `…+0100`.
std::optional<base::WallTime> ReadMoment(std::string_view text) {
  if (const auto time = base::ParseDateTime(text)) return time;
  if (const auto zulu = text.find('Z'); zulu != std::string_view::npos) {
    return base::ParseDateTime(text.substr(0, zulu + 1));
  }
  if (text.size() < 5) return std::nullopt;
  std::string with_colon(text);
  with_colon.insert(with_colon.size() - 2, ":");
  return base::ParseDateTime(with_colon);
}

Moment ReadWhen(const JsonValue& line, const Moment& last) {
  Moment moment = last;
  for (const std::string_view name : {"at", "timestamp", "tst"}) {
    if (const auto at = ReadMoment(StringMember(line, name))) {
      moment.at = *at;
      break;
    }
  }
  const auto t = ReadSeconds(FindMember(line, "t"));
  // Others say no t: it is what has passed by their clock, but it never runs backwards.
  const auto passed = std::chrono::duration_cast<microseconds>(moment.at - last.at);
  moment.t = t ? *t : last.t + std::max(passed, microseconds(0));
  return moment;
}

bool ReadFlag(const JsonValue& line, std::string_view name) {
  const JsonValue* value = FindMember(line, name);
  if (value == nullptr) return false;
  return value->IsBool() ? value->GetBool() : value->IsInt() && value->GetInt() != 0;
}

std::uint64_t ReadCount(const JsonValue& line, std::string_view name) {
  const JsonValue* value = FindMember(line, name);
  return value != nullptr && value->IsUint64() ? value->GetUint64() : 0;
}

int ReadQos(const JsonValue& line) {
  const std::uint64_t qos = ReadCount(line, "qos");
  return qos > 2 ? 0 : static_cast<int>(qos);
}

tl::unexpected<Error> Bad(std::string_view what) {
  return Fail(ErrorKind::kInvalid, std::string(what));
}

Result<std::string> ReadPayload(const JsonValue& line) {
  if (const JsonValue* coded = FindMember(line, "payload64")) {
    auto bytes = coded->IsString() ? DecodeBase64(base::ToView(*coded)) : std::nullopt;
    if (!bytes) return Bad("payload64 is no base64");
    return *std::move(bytes);
  }
  const JsonValue* payload = FindMember(line, "payload");
  if (payload == nullptr || payload->IsNull()) return std::string();
  return payload->IsString() ? std::string(base::ToView(*payload)) : base::ToJson(*payload);
}

Entry ReadHead(const JsonValue& line) {
  Head head;
  head.tool = StringMember(line, "tool");
  head.started = ReadMoment(StringMember(line, "started")).value_or(base::WallTime());
  head.broker = StringMember(line, "broker");
  head.mqtt_version = StringMember(line, "mqttVersion");
  head.qos = ReadQos(line);
  head.retain_as_published = ReadFlag(line, "retainAsPublished");
  head.part = static_cast<int>(std::min<std::uint64_t>(ReadCount(line, "part"), 1'000'000));
  head.time_zero = ReadSeconds(FindMember(line, "timeZero")).value_or(microseconds(0));
  if (const JsonValue* filters = base::FindArray(line, "subscriptions")) {
    for (const JsonValue& filter : filters->GetArray()) {
      if (filter.IsString()) head.subscriptions.emplace_back(base::ToView(filter));
    }
  }
  return head;
}

Entry ReadEvent(const JsonValue& line, const Moment& last) {
  Event event;
  static_cast<Moment&>(event) = ReadWhen(line, last);
  event.kind = StringMember(line, "event");
  event.text = StringMember(line, "message");
  event.messages = ReadCount(line, "messages");
  event.lasted = ReadSeconds(FindMember(line, "seconds")).value_or(microseconds(0));
  return event;
}

// The fields of one row.
std::vector<std::string> SplitRow(std::string_view row) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const char c = row[i];
    if (quoted && c == '"' && i + 1 < row.size() && row[i + 1] == '"') {
      fields.back() += c;
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

std::optional<double> ReadNumber(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_one = error == std::errc() && end == text.data() + text.size();
  return is_one && std::abs(number) < 9e9 ? std::optional(number) : std::nullopt;
}

}  // namespace

std::string ToLine(const Head& head) {
  return fmt::format(
      R"({{"format":"{}","version":{},"tool":{},"started":"{}","broker":{},"mqttVersion":{},)"
      R"("qos":{},"retainAsPublished":{},"subscriptions":{},"timeZero":{},"part":{}}})"
      "\n",
      kFormat, kFormatVersion, JsonString(head.tool), base::FormatTimestamp(head.started),
      JsonString(head.broker), JsonString(head.mqtt_version), head.qos, head.retain_as_published,
      base::JsonStrings(head.subscriptions), Seconds(head.time_zero), head.part);
}

std::string ToLine(const Message& message) {
  const bool is_text =
      base::IsUtf8(message.payload) && message.payload.find('\0') == std::string::npos;
  return fmt::format(
      R"({{{},"timestamp":"{}","topic":{},"qos":{},"retain":{},"dup":{},"{}":{}}})"
      "\n",
      When(message), base::FormatTimestamp(message.at), JsonString(message.topic), message.qos,
      message.retain, message.dup, is_text ? "payload" : "payload64",
      is_text ? JsonString(message.payload) : JsonString(EncodeBase64(message.payload)));
}

std::string ToLine(const Event& event) {
  std::string line = fmt::format(R"({{{},"event":{})", When(event), JsonString(event.kind));
  if (!event.text.empty()) line += fmt::format(R"(,"message":{})", JsonString(event.text));
  if (event.messages > 0) line += fmt::format(R"(,"messages":{})", event.messages);
  if (event.lasted.count() > 0) line += fmt::format(R"(,"seconds":{})", Seconds(event.lasted));
  return line + "}\n";
}

std::string ToLine(const Foot& foot) {
  return fmt::format(R"({{"ended":"{}","count":{},"sha256":"{}"}})"
                     "\n",
                     base::FormatTimestamp(foot.ended), foot.count, foot.sha256);
}

Result<std::optional<Entry>> ParseJsonLine(std::string_view line, const Moment& last) {
  const auto parsed = base::ParseJsonLeniently(line, {.bytes = line.size()});
  if (!parsed) return Fail(parsed.error());
  if (!parsed->IsObject()) return Bad("it is no JSON object");
  if (StringMember(*parsed, "format") == kFormat) {
    if (ReadCount(*parsed, "version") > kFormatVersion) {
      return Bad("the recording is of a newer version of fleetpub than this one");
    }
    return ReadHead(*parsed);
  }
  const JsonValue* topic = FindMember(*parsed, "topic");
  if (topic != nullptr && topic->IsString() && !base::ToView(*topic).empty()) {
    auto payload = ReadPayload(*parsed);
    if (!payload) return Fail(std::move(payload.error()));
    Message message;
    static_cast<Moment&>(message) = ReadWhen(*parsed, last);
    message.topic = base::ToView(*topic);
    message.payload = *std::move(payload);
    message.qos = ReadQos(*parsed);
    message.retain = ReadFlag(*parsed, "retain");
    message.dup = ReadFlag(*parsed, "dup");
    return message;
  }
  if (!StringMember(*parsed, "event").empty()) return ReadEvent(*parsed, last);
  if (!StringMember(*parsed, "sha256").empty()) {
    return Foot{.ended = ReadMoment(StringMember(*parsed, "ended")).value_or(base::WallTime()),
                .count = ReadCount(*parsed, "count"),
                .sha256 = std::string(StringMember(*parsed, "sha256"))};
  }
  return std::optional<Entry>();
}

bool IsOpenRow(std::string_view row) { return std::count(row.begin(), row.end(), '"') % 2 != 0; }

Result<Message> ParseCsvRow(std::string_view row) {
  std::vector<std::string> fields = SplitRow(row);
  if (fields.size() < 5 || fields[0].empty()) return Bad("it is neither JSON nor a row of CSV");
  const auto qos = ReadNumber(fields[2]);
  const auto epoch = ReadNumber(fields[4]);
  if (!qos || !epoch || *qos < 0 || *qos > 2) {
    return Bad("it is no row of topic, payload, qos, retain, time, delay");
  }
  Message message;
  message.topic = std::move(fields[0]);
  message.payload = std::move(fields[1]);
  message.qos = static_cast<int>(*qos);
  message.retain = base::EqualsIgnoringCase(fields[3], "true") || fields[3] == "1";
  message.at = base::WallTime(microseconds(std::llround(*epoch * 1e6)));
  // The file does not say whether payloads are coded; messages of ours are JSON objects.
  if (!message.payload.starts_with('{')) {
    auto decoded = DecodeBase64(message.payload);
    if (decoded && decoded->starts_with('{')) message.payload = *std::move(decoded);
  }
  return message;
}

}  // namespace fleetpub::recording
