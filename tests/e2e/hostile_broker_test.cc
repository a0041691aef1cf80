// Brokers that mean harm, over every transport: what they send ends the connection with a sentence,
// never the process, and what is recorded stays true.
#include <gmock/gmock.h>

#include <string_view>

#include "mqtt/certificates.h"
#include "support/front.h"
#include "support/operator.h"
#include "support/publish_packet.h"
#include "support/scripted_broker.h"

namespace fleetpub::testing {
namespace {

using mqtt::Certificates;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr std::string_view kNoPropertyLength{"\x30\x04\0\1a\x80", 6};
constexpr std::string_view kNoPropertyLengthAtQos1{"\x32\x06\0\1a\0\1\x80", 8};

/// The scheme that the operator writes.
class HostileBroker : public ::testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] static bool IsEncrypted() {
    return std::string_view(GetParam()).ends_with('s') && GetParam() != std::string_view("ws");
  }
  [[nodiscard]] Finished Call(const ScriptedBroker& broker,
                              std::vector<std::string> arguments) const {
    const auto& files = Certificates::Get();
    const Front front(broker.port(), GetParam(), files / "server.crt", files / "server.key");
    arguments.insert(arguments.end(), {"-b", front.Url()});
    if (IsEncrypted()) arguments.insert(arguments.end(), {"--cafile", files / "ca.crt"});
    return operator_.Fleetpub(std::move(arguments));
  }
  [[nodiscard]] std::vector<std::string> History() const {
    return Lines(operator_.Fleetpub({"history", "-o", "json"}).output);
  }

  Operator operator_;
};

INSTANTIATE_TEST_SUITE_P(Over, HostileBroker, ::testing::Values("mqtt", "mqtts", "ws", "wss"),
                         [](const auto& scheme) { return std::string(scheme.param); });

TEST_P(HostileBroker, GetsNoMessageWhenItsSubackIsNone) {
  for (const auto packet : {kNoPropertyLength, kNoPropertyLengthAtQos1}) {
    const ScriptedBroker broker({.on_subscribe = std::string(packet)});
    for (const char* qos : {"0", "1"}) {
      for (const std::vector<std::string>& more :
           {std::vector<std::string>{}, WithoutLook({"--wait"})}) {
        std::vector<std::string> words = {"pause", "KIT/0001", "-V", "5", "-q", qos};
        words.insert(words.end(), more.begin(), more.end());
        const Finished run = Call(broker, words);
        EXPECT_EQ(run.exit_code, 4) << run.output << run.errors;
        EXPECT_THAT(run.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr("PUBLISH"),
                                      HasSubstr("malformed packet")));
      }
    }
    EXPECT_EQ(broker.published(), 0);
  }
  EXPECT_THAT(History(), IsEmpty());
}

TEST_P(HostileBroker, LeavesNoFalseRowWhenItAnswersAMessageWithNonsense) {
  for (const auto packet : {kNoPropertyLength, kNoPropertyLengthAtQos1}) {
    const ScriptedBroker broker({.on_publish = std::string(packet)});
    const Finished published =
        Call(broker, WithoutLook({"pause", "KIT/0001", "-V", "5", "-q", "1"}));
    EXPECT_EQ(published.exit_code, 4) << published.output << published.errors;
    EXPECT_THAT(published.output, HasSubstr("malformed packet"));
    // Who waits for the robot connects again: its answer may still come.
    for (const char* qos : {"0", "1"}) {
      const Finished waited =
          Call(broker,
               WithoutLook({"pause", "KIT/0001", "-V", "5", "-q", qos, "--wait", "-W", "300ms"}));
      EXPECT_THAT(waited.exit_code, AnyOf(4, 6)) << waited.output << waited.errors;
      EXPECT_THAT(waited.output + waited.errors, HasSubstr("malformed packet"));
    }
    EXPECT_EQ(broker.published(), 3);
  }
  const auto rows = History();
  EXPECT_EQ(rows.size(), 6U);
  EXPECT_THAT(rows, Not(Contains(HasSubstr(R"("status":"RECORDED")"))));
}

TEST_P(HostileBroker, IsQuotedWhenItEndsTheConnection) {
  const ScriptedBroker broker(
      {.on_publish = std::string("\xe0\x0a\x97\x08\x1f\0\5quota", 12), .hangs_up_after = 3});
  const Finished run = Call(broker, WithoutLook({"pause", "KIT/0001", "-V", "5", "-q", "1"}));
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_THAT(run.output + run.errors, HasSubstr("quota exceeded (0x97), 'quota'"));
}

TEST_P(HostileBroker, IsQuotedWhenItRefusesAMessageOrASubscription) {
  const ScriptedBroker full({.on_publish = std::string("\x40\x0c\0\1\x97\x08\x1f\0\5quota", 14)});
  const Finished sent = Call(full, WithoutLook({"pause", "KIT/0001", "-V", "5", "-q", "1"}));
  EXPECT_EQ(sent.exit_code, 4);
  EXPECT_THAT(sent.output + sent.errors, HasSubstr("quota exceeded (0x97), 'quota'"));
  const ScriptedBroker closed(
      {.on_subscribe = std::string("\x90\x0f\0\1\x08\x1f\0\5staff\x87\x87\x87\x87", 17)});
  const Finished asked = Call(closed, {"await", "KIT/0001", "paused=true", "-V", "5"});
  EXPECT_EQ(asked.exit_code, 4);
  EXPECT_THAT(asked.output + asked.errors, HasSubstr("not authorized (0x87), 'staff'"));
}

// A message that has left at QoS 0 has left, whatever follows.
TEST_P(HostileBroker, DoesNotUndoAMessageAtQos0) {
  const ScriptedBroker broker({.on_publish = std::string(kNoPropertyLength)});
  const Finished run = Call(broker, WithoutLook({"pause", "KIT/0001", "-V", "5", "-q", "0"}));
  EXPECT_THAT(run.exit_code, AnyOf(0, 4)) << run.output << run.errors;
  EXPECT_THAT(History(), Not(Contains(HasSubstr(R"("status":"RECORDED")"))));
}

TEST_P(HostileBroker, IsLostByWhoOnlyListens) {
  for (const char* version : {"3.1.1", "5"}) {
    const ScriptedBroker broker({.on_subscribe = std::string("\x30\x03\0\2a", 5)});
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"fleet"}, {"await", "KIT/0001", "state", "paused=true"}}) {
      std::vector<std::string> all = words;
      all.insert(all.end(), {"-V", version});
      const Finished run = Call(broker, all);
      EXPECT_EQ(run.exit_code, 4) << run.output << run.errors;
      EXPECT_THAT(run.errors, HasSubstr("malformed packet"));
    }
  }
}

// ── what it makes us keep ──

constexpr std::size_t kMostMib = 64;

std::string Filled(std::string_view topic, std::size_t payload) {
  return PublishPacket(topic, std::string(payload, 'x'));
}

std::string Times(int times, const std::string& text) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

class GreedyBroker : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
#ifdef FLEETPUB_SLOW
    GTEST_SKIP() << "a sanitizer keeps more than a broker could make us keep";
#endif
  }
  [[nodiscard]] Finished Call(const ScriptedBroker& broker,
                              std::vector<std::string> arguments) const {
    const Front front(broker.port(), GetParam(), "", "");
    arguments.insert(arguments.end(), {"-b", front.Url()});
    return operator_.Fleetpub(std::move(arguments));
  }

  Operator operator_;
};

INSTANTIATE_TEST_SUITE_P(Over, GreedyBroker, ::testing::Values("mqtt", "ws"),
                         [](const auto& scheme) { return std::string(scheme.param); });

TEST_P(GreedyBroker, FloodsUsWithNothingBeforeItsSuback) {
  const std::pair<std::string, std::string> floods[] = {
      {Times(10'000, std::string("\x90\3\0\1\0", 5)), "SUBACK"},
      {Times(100, Filled("vda5050/v3/KIT/0001/state", 5'000)), "wait to be read"},
      {Times(10'000, Filled("t", 0)), "wait to be read"}};
  for (const auto& [flood, words] : floods) {
    const ScriptedBroker broker({.on_subscribe = flood, .times = 1'000});
    const Finished run = Call(broker, WithoutLook({"pause", "KIT/0001", "--wait"}));
    EXPECT_EQ(run.exit_code, 4) << run.output << run.errors;
    EXPECT_THAT(run.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr(words)));
    EXPECT_LT(run.peak_mib, kMostMib) << words;
    EXPECT_EQ(broker.published(), 0);
  }
}

TEST_P(GreedyBroker, FloodsUsWithNothingInsteadOfAnAcknowledgement) {
  const std::string floods[] = {
      Times(100, Filled("vda5050/v3/KIT/0001/state", 5'000)),
      Times(10'000, std::string("\x40\2\x7F\1", 4)),  // PUBACK of what was never sent
      Times(10'000, std::string("\x50\2\x7F\1", 4)),
      Times(10'000, std::string("\xD0\0", 2)),
  };
  for (const std::string& flood : floods) {
    const ScriptedBroker broker({.on_publish = flood, .times = 1'000});
    const Finished run =
        Call(broker, WithoutLook({"pause", "KIT/0001", "-q", "1", "--connect-timeout", "300ms"}));
    EXPECT_EQ(run.exit_code, 4) << run.output << run.errors;
    EXPECT_LT(run.peak_mib, kMostMib);
  }
}

TEST_P(GreedyBroker, CannotSendOneHugePacket) {
  const std::string head("\x30\xFF\xFF\xFF\x7F\0\1t", 8);
  const ScriptedBroker broker({.on_subscribe = head + std::string(1 << 20, 'x'), .times = 50});
  const Finished run = Call(broker, {"fleet"});
  EXPECT_EQ(run.exit_code, 4) << run.output << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("268435455 bytes"));
  EXPECT_LT(run.peak_mib, kMostMib);
}

TEST_P(GreedyBroker, SendsTheLargestPacketThatWeTake) {
  constexpr std::string_view kTopic = "vda5050/v3/KIT/0001/state";
  const ScriptedBroker broker({.after_suback = Filled(kTopic, 17'800'000)});
  const Finished run = Call(broker, {"await", "KIT/0001", "state", "a=1", "-W", "2s"});
  EXPECT_EQ(run.exit_code, 6) << run.output << run.errors;
  EXPECT_LT(run.peak_mib, kMostMib + 16) << "five times itself: Paho's two copies and ours";
}

}  // namespace
}  // namespace fleetpub::testing
