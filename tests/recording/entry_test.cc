#include "recording/entry.h"

#include <gmock/gmock.h>

#include "base/json.h"
#include "schema/schema.h"

namespace fleetpub::recording {
namespace {

using std::chrono::microseconds;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

Moment At(std::int64_t t, std::string_view at) {
  return {.t = microseconds(t), .at = *base::ParseDateTime(at)};
}

Message Example() {
  Message message;
  static_cast<Moment&>(message) = At(12'345'678, "2026-03-04T05:06:07.089Z");
  message.topic = "uagv/v2/KIT/0001/state";
  message.payload = R"({"headerId": 10000000000000001, "x": 1.0, "text": "ä\u0007 \"q\""})";
  message.qos = 1;
  message.retain = true;
  message.dup = true;
  return message;
}

Entry Parse(std::string_view line, const Moment& last = {}) {
  const auto entry = ParseJsonLine(line, last);
  EXPECT_TRUE(entry) << line;
  EXPECT_TRUE(entry && *entry) << line;
  return entry && *entry ? **entry : Entry();
}

Message ParseMessage(std::string_view line, const Moment& last = {}) {
  const Entry entry = Parse(line, last);
  const auto* message = std::get_if<Message>(&entry);
  EXPECT_NE(message, nullptr) << line;
  return message == nullptr ? Message() : *message;
}

TEST(RecordingEntry, ComesBackAsItWasWritten) {
  const Message message = Example();
  const Message read = ParseMessage(ToLine(message));
  EXPECT_EQ(read.t, message.t);
  EXPECT_EQ(read.at, message.at);
  EXPECT_EQ(read.topic, message.topic);
  EXPECT_EQ(read.payload, message.payload);
  EXPECT_EQ(read.qos, 1);
  EXPECT_TRUE(read.retain && read.dup);
}

TEST(RecordingEntry, KeepsBytesThatAreNoText) {
  using namespace std::string_literals;
  for (const std::string& payload : {"\xff\xfe"s, "a\0b"s, "\xed\xa0\x80"s, "\x80"s, "\xc3"s}) {
    Message message = Example();
    message.payload = payload;
    const std::string line = ToLine(message);
    EXPECT_THAT(line, HasSubstr("payload64"));
    EXPECT_EQ(ParseMessage(line).payload, payload);
  }
  Message empty = Example();
  empty.payload.clear();
  EXPECT_THAT(ToLine(empty), HasSubstr(R"("payload":"")"));
  EXPECT_EQ(ParseMessage(ToLine(empty)).payload, "");
}

TEST(RecordingEntry, IsAsItsSchemaSays) {
  schema::Registry registry;
  const auto schema = registry.Find("fleetpub/recording");
  ASSERT_TRUE(schema) << schema.error().message;
  Message coded = Example();
  coded.payload = "\xff";
  Event gap;
  gap.kind = "gap";
  gap.lasted = microseconds(1'500'000);
  Event overflow;
  overflow.kind = "overflow";
  overflow.messages = 7;
  const Head head{.tool = "fleetpub", .broker = "mqtt://north:1883", .mqtt_version = "5"};
  const Foot foot{.count = 3, .sha256 = std::string(64, 'a')};
  for (const std::string& line : {ToLine(Example()), ToLine(coded), ToLine(gap), ToLine(overflow),
                                  ToLine(head), ToLine(foot)}) {
    const auto document = base::ParseJson(line);
    ASSERT_TRUE(document) << line;
    EXPECT_THAT((*schema)->Validate(*document), IsEmpty()) << line;
    EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
  }
}

TEST(RecordingEntry, ReadsWhatMosquittoSubWrites) {
  const Message old = ParseMessage(
      R"({"tst":"2026-11-29T07:12:08.330735Z+0000","topic":"a/b","qos":0,"retain":1,"payloadlen":3,"payload":"x\"y"})");
  EXPECT_EQ(old.at, *base::ParseDateTime("2026-11-29T07:12:08.330735Z"));
  EXPECT_EQ(old.payload, "x\"y");
  EXPECT_TRUE(old.retain);
  const Message recent = ParseMessage(
      R"({"tst":"2026-11-29T08:12:08.000001+0100","topic":"a","qos":1,"retain":false,"payload":null,"mid":3})");
  EXPECT_EQ(recent.at, *base::ParseDateTime("2026-11-29T07:12:08.000001Z"));
  EXPECT_EQ(recent.payload, "");
  EXPECT_EQ(recent.qos, 1);
  const Message parsed = ParseMessage(R"({"tst":"","topic":"a","payload":{"b":[1]}})");
  EXPECT_EQ(parsed.payload, R"({"b":[1]})");
}

TEST(RecordingEntry, TakesTheTimeThatPassedWhereNoneIsSaid) {
  const Moment last = At(5'000'000, "2026-01-01T00:00:10Z");
  EXPECT_EQ(
      ParseMessage(R"({"timestamp":"2026-01-01T00:00:11.5Z","topic":"a","payload":""})", last).t,
      microseconds(6'500'000));
  EXPECT_EQ(
      ParseMessage(R"({"timestamp":"2026-01-01T00:00:09Z","topic":"a","payload":""})", last).t,
      microseconds(5'000'000));
}

TEST(RecordingEntry, RefusesWhatItCannotRead) {
  for (const char* line : {"{", "[]", "null", "\"a\"", R"({"topic":"a","payload64":"?"})",
                           R"({"topic":"a","payload64":"QQ="})", R"({"topic":"a","payload64":1})",
                           R"({"format":"fleetpub-recording","version":2})"}) {
    EXPECT_FALSE(ParseJsonLine(line, {})) << line;
  }
  for (const char* line : {"{}", R"({"topic":1})", R"({"topic":""})", R"({"record_type":"x"})"}) {
    const auto entry = ParseJsonLine(line, {});
    ASSERT_TRUE(entry) << line;
    EXPECT_FALSE(*entry) << line;
  }
}

TEST(RecordingEntry, ReadsHostileNumbersAsNone) {
  for (const char* t : {"1e300", "-1e300", "\"1\"", "null", "{}"}) {
    EXPECT_EQ(ParseMessage(fmt::format(R"({{"t":{},"topic":"a","payload":""}})", t)).t.count(), 0);
  }
  EXPECT_EQ(ParseMessage(R"({"qos":3,"topic":"a","payload":""})").qos, 0);
  EXPECT_EQ(ParseMessage(R"({"qos":-1,"topic":"a","payload":""})").qos, 0);
}

TEST(RecordingCsv, ReadsRowsOfMqttRecorder) {
  const auto plain = ParseCsvRow(R"(a/state,"{""x"": ""1,2""}",1,True,1700000000.25,0.5)");
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->payload, R"({"x": "1,2"})");
  EXPECT_EQ(plain->qos, 1);
  EXPECT_TRUE(plain->retain);
  EXPECT_EQ(plain->at, base::WallTime(microseconds(1'700'000'000'250'000)));
  const auto coded = ParseCsvRow("a/state,eyJ4IjoxfQ==,0,False,1700000000,0");
  ASSERT_TRUE(coded);
  EXPECT_EQ(coded->payload, R"({"x":1})");
  EXPECT_EQ(ParseCsvRow("a,abcd,0,False,1,0")->payload, "abcd");
}

TEST(RecordingCsv, RefusesOtherRows) {
  for (const char* row : {"", "a", "a,b,c,d,e,f", ",b,0,False,1,0", "a,b,3,False,1,0",
                          "a,b,0,False,1e99,0", "a,b,0,False,nan,0"}) {
    EXPECT_FALSE(ParseCsvRow(row)) << row;
  }
  EXPECT_TRUE(IsOpenRow("a,\"b"));
  EXPECT_FALSE(IsOpenRow("a,\"b\"\"\""));
}

}  // namespace
}  // namespace fleetpub::recording
