#include "cli/parser/value_kind.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "vda5050/catalogue/parameter.h"

namespace fleetpub::cli {
namespace {

std::string_view FindWord(std::span<const std::string_view> words, std::string_view text) {
  const auto word = std::find_if(words.begin(), words.end(), [&](std::string_view known) {
    return base::EqualsIgnoringCase(known, text);
  });
  return word == words.end() ? std::string_view() : *word;
}

std::string ListWords(const std::vector<std::string_view>& words) {
  const std::vector<std::string> all_but_last(words.begin(), words.end() - 1);
  return fmt::format("{} or {}", base::Join(all_but_last, ", "), words.back());
}

std::vector<std::string_view> VersionNames() {
  std::vector<std::string_view> names;
  names.reserve(std::size(vda5050::kVersions));
  for (const vda5050::Version version : vda5050::kVersions) {
    names.push_back(vda5050::GetFacts(version).name);
  }
  return names;
}

}  // namespace

std::string ValueKind::Takes() const { return takes ? takes() : ListWords(choices()); }

ValueKind Text(std::string& value) {
  return {"TEXT", [&value](const std::vector<std::string>& texts) {
            value = texts.front();
            return true;
          }};
}

ValueKind Text(std::optional<std::string>& value) {
  return {"TEXT", [&value](const std::vector<std::string>& texts) {
            value = texts.front();
            return true;
          }};
}

ValueKind Text(std::vector<std::string>& values) {
  return {.type = "TEXT",
          .store =
              [&values](const std::vector<std::string>& texts) {
                values = texts;
                return true;
              },
          .is_list = true};
}

ValueKind Flag(bool& value) {
  return {"", [&value](const std::vector<std::string>& texts) {
            value = texts.front() == "true";
            return true;
          }};
}

ValueKind Only(ValueKind kind, bool (*holds)(const std::string& text), std::string takes) {
  kind.store = [holds, store = std::move(kind.store)](const std::vector<std::string>& texts) {
    return std::all_of(texts.begin(), texts.end(), holds) && store(texts);
  };
  kind.takes = [takes = std::move(takes)] { return takes; };
  return kind;
}

ValueKind NewFile(std::string& value) {
  return Only(
      Text(value), [](const std::string& text) { return text != "-"; },
      "a file's name (standard output has the results: fleetpub tail -o json prints messages "
      "there)");
}

ValueKind Interval(std::chrono::milliseconds& value) {
  const auto is_above_zero = [](const std::string& text) {
    const auto parsed = base::ParseDuration(text);
    return parsed && parsed->count() > 0;
  };
  return Only(Duration(value), is_above_zero,
              "a duration above zero, such as 250ms, 30s or 5m, of at most ten years");
}

ValueKind PointInTime(std::optional<base::WallTime>& value, base::Direction direction) {
  return {"TIME",
          internal::StoreOne(value,
                             [direction](const std::string& text) {
                               const auto now = base::WallTime::clock::now();
                               auto time = base::ParseDateTime(text);
                               if (!time) time = base::ParseLocalTime(text, now, direction);
                               if (time) return time;
                               const auto from_now = base::ParseDuration(text);
                               if (from_now) time = now + *from_now * static_cast<int>(direction);
                               return time;
                             }),
          [] {
            return std::string(
                "a time such as 14:30, today, 'monday 06:00', 2026-01-02 or 2026-01-02T03:04:05Z, "
                "or a duration such as 24h, of at most ten years");
          }};
}

ValueKind Rate(std::optional<double>& value) {
  return {"N",
          internal::StoreOne(value,
                             [](const std::string& text) { return ParseBetween(text, 1e-3, 1e6); }),
          [] { return std::string("messages per second, from 0.001 to 1000000"); }};
}

ValueKind Percentage(double& value) {
  return {"PERCENT",
          internal::StoreOne(value,
                             [](std::string text) {
                               if (text.ends_with('%')) text.pop_back();
                               auto percent = ParseBetween(text, 0.0, 100.0);
                               if (percent) *percent /= 100;
                               return percent;
                             }),
          [] { return std::string("a percentage from 0 to 100"); }};
}

ValueKind Measure(std::optional<double>& value, vda5050::ParameterType type) {
  const bool is_angle = type == vda5050::ParameterType::kAngle;
  const auto parse = [type](const std::string& text) -> std::optional<double> {
    const auto parameter = vda5050::ParseParameter({"", type, true, ""}, text);
    return parameter ? ParseBetween(parameter->json, 0.0, 1e9) : std::nullopt;
  };
  return {is_angle ? "RAD" : "M", internal::StoreOne(value, parse), [is_angle] {
            return std::string(is_angle ? "an angle from 0 to π, such as 0.5 or 30deg"
                                        : "a length, such as 0.2 or 20cm");
          }};
}

ValueKind OneOf(std::string& value, std::span<const std::string_view> words) {
  return {.type = "WORD",
          .store =
              [&value, words](const std::vector<std::string>& texts) {
                const std::string_view word = FindWord(words, texts.front());
                if (word.empty() && !texts.front().empty()) return false;
                value = word;
                return true;
              },
          .choices = [words] { return std::vector(words.begin(), words.end()); }};
}

ValueKind VdaVersion(std::string& value, Automatic automatic) {
  const bool may_be_automatic = automatic == Automatic::kYes;
  return {.type = "V",
          .store =
              [&value, may_be_automatic](const std::vector<std::string>& texts) {
                const std::string& text = texts.front();
                const bool is_right = text.empty() || (may_be_automatic && text == "auto") ||
                                      vda5050::ParseVersion(text).has_value();
                if (is_right) value = text;
                return is_right;
              },
          .takes =
              [may_be_automatic] {
                return ListWords(VersionNames()) + (may_be_automatic ? ", or auto" : "");
              },
          .choices =
              [may_be_automatic] {
                auto names = VersionNames();
                if (may_be_automatic) names.emplace_back("auto");
                return names;
              }};
}

}  // namespace fleetpub::cli
