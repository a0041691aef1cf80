#include "cli/output/test_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/json.h"
#include "base/text.h"
#include "cli/output/stop_signal.h"

namespace fleetpub::cli {
namespace {

using app::Verdict;

// For XML and HTML, element or attribute; characters that XML 1.0 has not are shown as Printable does.
std::string Escaped(std::string_view text) {
  std::string escaped;
  for (const char c : base::Printable(text)) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

VerdictCounts CountVerdicts(const TestReport& report) {
  VerdictCounts counts;
  for (const TestResult& one : report.results) counts.Add(one.verdict);
  return counts;
}

double Seconds(const TestReport& report) {
  return std::chrono::duration<double>(report.elapsed).count();
}

std::string Title(const TestResult& one) {
  return one.says.empty() ? one.id : one.id + " " + one.says;
}

// In TAP a number sign begins a directive.
std::string TapText(std::string_view text) {
  std::string escaped;
  for (const char c : base::Printable(text)) {
    if (c == '#' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

constexpr std::string_view kStyle =
    "body{font:15px/1.45 system-ui,sans-serif;margin:2em auto;max-width:62em;padding:0 1em;"
    "color:#1b1b1b}h1{font-size:1.5em}table{border-collapse:collapse;width:100%}"
    "td,th{border-bottom:1px solid #ccc;padding:.35em .6em;text-align:left;vertical-align:top}"
    "tr{break-inside:avoid}.v{font-weight:600;white-space:nowrap}.PASS{color:#176b2c}"
    ".FAIL{color:#b00020}.SKIPPED,.INCONCLUSIVE{color:#6a5700}small{color:#555}"
    "@media print{body{margin:0;max-width:none;font-size:11px}}";

}  // namespace

std::string VerdictColumn(Verdict verdict, const Output& output) {
  const Tone tone = verdict == Verdict::kPass   ? Tone::kGood
                    : verdict == Verdict::kFail ? Tone::kBad
                                                : Tone::kWarn;
  return output.Toned(tone, fmt::format("{:<12}", GetName(verdict)));
}

std::string SeeEvidence(const std::vector<std::string>& evidence) {
  return evidence.empty() ? "" : "; see " + base::Join(evidence, ", ");
}

void VerdictCounts::Add(Verdict verdict) {
  switch (verdict) {
    case Verdict::kPass:
      ++passed;
      break;
    case Verdict::kFail:
      ++failed;
      break;
    case Verdict::kSkipped:
      ++skipped;
      break;
    case Verdict::kInconclusive:
      ++inconclusive;
  }
}

std::string VerdictCounts::ToText() const {
  return fmt::format("{} passed, {} failed, {} skipped, {} inconclusive", passed, failed, skipped,
                     inconclusive);
}

std::string VerdictCounts::ToJson() const {
  return fmt::format(R"("passed":{},"failed":{},"skipped":{},"inconclusive":{})", passed, failed,
                     skipped, inconclusive);
}

ExitCode VerdictCounts::ToExitCode(bool is_open) const {
  if (const auto stopped = StopSignal::Received()) return *stopped;
  if (failed > 0) return ExitCode::kRejected;
  return is_open ? ExitCode::kUnconfirmed : ExitCode::kDone;
}

std::string ToJUnit(const TestReport& report) {
  const VerdictCounts verdicts = CountVerdicts(report);
  const std::string counts =
      fmt::format(R"(tests="{}" failures="{}" errors="0" skipped="{}" time="{:.3f}")",
                  report.results.size(), verdicts.failed, verdicts.undecided(), Seconds(report));
  std::string time = base::FormatTimestamp(report.started);
  time.resize(19);  // JUnit's has neither fraction nor zone
  const std::string name = Escaped(report.name);
  std::string xml = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"{0}\" {1}>\n"
      "  <testsuite name=\"{0}\" timestamp=\"{2}\" {1}>\n    <properties>\n",
      name, counts, time);
  for (const auto& [key, value] : report.properties) {
    xml +=
        fmt::format("      <property name=\"{}\" value=\"{}\"/>\n", Escaped(key), Escaped(value));
  }
  xml += "    </properties>\n";
  for (const TestResult& one : report.results) {
    xml += fmt::format("    <testcase classname=\"{}.{}\" name=\"{}\" time=\"0\"", name,
                       Escaped(one.group), Escaped(Title(one)));
    if (one.verdict == Verdict::kPass) {
      xml += "/>\n";
      continue;
    }
    const std::string_view verdict = GetName(one.verdict);
    const std::string why = fmt::format("{}: {}", verdict, Escaped(one.why));
    xml += one.verdict == Verdict::kFail
               ? fmt::format("><failure type=\"{}\" message=\"{}\">{}</failure></testcase>\n",
                             verdict, why, Escaped(base::Join(one.details, "; ")))
               : fmt::format("><skipped message=\"{}\"/></testcase>\n", why);
  }
  return xml + "  </testsuite>\n</testsuites>\n";
}

std::string ToTap(const TestReport& report) {
  std::string tap = fmt::format("TAP version 13\n1..{}\n", report.results.size());
  std::size_t number = 0;
  for (const TestResult& one : report.results) {
    const bool has_failed = one.verdict == Verdict::kFail;
    const bool is_skipped = !has_failed && one.verdict != Verdict::kPass;
    tap += fmt::format(
        "{} {} - {}{}\n", has_failed ? "not ok" : "ok", ++number, TapText(Title(one)),
        is_skipped ? fmt::format(" # SKIP {}: {}", GetName(one.verdict), TapText(one.why)) : "");
    if (!has_failed) continue;
    tap += "# " + base::Printable(one.why) + "\n";
    for (const std::string& detail : one.details) tap += "# " + base::Printable(detail) + "\n";
  }
  return tap;
}

std::string ToJson(const TestReport& report) {
  std::string properties;
  for (const auto& [key, value] : report.properties) {
    properties += fmt::format("{}{}:{}", properties.empty() ? "" : ",", base::JsonString(key),
                              base::JsonString(value));
  }
  std::string results;
  for (const TestResult& one : report.results) {
    results += fmt::format(R"({}{{"id":{},"says":{},"verdict":{},"why":{},"details":{}}})",
                           results.empty() ? "" : ",", base::JsonString(one.id),
                           base::JsonString(one.says), base::JsonString(GetName(one.verdict)),
                           base::JsonString(one.why), base::JsonStrings(one.details));
  }
  const VerdictCounts verdicts = CountVerdicts(report);
  return fmt::format(
      R"({{"name":{},"started":"{}","elapsedMs":{},"passed":{},"failed":{},"skipped":{},)"
      R"("properties":{{{}}},"results":[{}]}})"
      "\n",
      base::JsonString(report.name), base::FormatTimestamp(report.started), report.elapsed.count(),
      verdicts.passed, verdicts.failed, verdicts.undecided(), properties, results);
}

std::string ToHtml(const TestReport& report) {
  const std::string name = Escaped(report.name);
  const VerdictCounts verdicts = CountVerdicts(report);
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title>\n"
      "<style>{1}</style></head><body>\n<h1>{0}</h1>\n<p>{2}, {3}. {4} passed, {5} failed, {6} not "
      "judged.</p>\n<table>\n",
      name, kStyle, base::FormatTimestamp(report.started), base::FormatElapsed(report.elapsed),
      verdicts.passed, verdicts.failed, verdicts.undecided());
  for (const auto& [key, value] : report.properties) {
    html += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", Escaped(key), Escaped(value));
  }
  html += "</table>\n<table>\n<tr><th></th><th>Case</th><th>What was found</th></tr>\n";
  for (const TestResult& one : report.results) {
    std::string details;
    for (const std::string& detail : one.details)
      details += "<br><small>" + Escaped(detail) + "</small>";
    html += fmt::format(
        "<tr><td class=\"v {0}\">{0}</td><td><b>{1}</b> {2}</td><td>{3}{4}</td></tr>\n",
        GetName(one.verdict), Escaped(one.id), Escaped(one.says), Escaped(one.why), details);
  }
  return html + "</table>\n</body></html>\n";
}

}  // namespace fleetpub::cli
