#include "vda5050/model/robot_address.h"

#include <gmock/gmock.h>

namespace fleetpub::vda5050 {
namespace {

using ::testing::HasSubstr;

const RobotAddress kRobot{"KIT", "0001"};

std::string Refusal(std::string_view text) {
  const auto robot = ParseRobotAddress(text);
  if (robot) return "";
  EXPECT_EQ(robot.error().kind, ErrorKind::kUsage);
  return robot.error().message;
}

// The topic, or the refusal.
std::string Topic(const TopicScheme& scheme, Version version = Version::k300,
                  const RobotAddress& robot = kRobot) {
  const auto topic = TopicFor(scheme, version, robot, "instantActions");
  if (topic) return *topic;
  EXPECT_EQ(topic.error().kind, ErrorKind::kUsage);
  return topic.error().message;
}

TEST(ParseRobotAddress, SplitsManufacturerAndSerialNumber) {
  for (const std::string text : {"KIT/0001", "a/b", "Jungheinrich AG/ERC 213-7", "Bär/Nr.1:2_3"}) {
    const auto robot = ParseRobotAddress(text);
    ASSERT_TRUE(robot) << text;
    EXPECT_EQ(robot->ToString(), text);
  }
  EXPECT_EQ(*ParseRobotAddress("KIT/0001"), kRobot);
}

// A robot's names, and the word for it.
const std::vector<std::pair<RobotAddress, std::string>> kWords = {
    {{"*", "*"}, "%2A/%2A"},
    {{"KIT", "000?"}, "KIT/000%3F"},
    {{"@hall", "@1"}, "%40hall/@1"},
    {{"--all", "-1"}, "%2D-all/-1"},
    {{"[KIT", "1]"}, "%5BKIT/1]"},
    {{" KIT ", " 1 "}, "%20KIT%20/%201%20"},
    {{"KIT", "1 --all @a b"}, "KIT/1 %2D-all %40a b"},
    {{"50%2A", "%"}, "50%252A/%25"},
    {{"a\"b'c\\", "1"}, "a%22b%27c%5C/1"},
    {{"K\u202EIT", "\u3164"}, "K%E2%80%AEIT/%E3%85%A4"},
    {{"KIT", "\u00A01"}, "KIT/%C2%A01"},
};

TEST(ParseRobotAddress, RefusesTheSameWhenItIsEscaped) {
  EXPECT_THAT(Refusal("KIT/a%2Fb"), HasSubstr("separates topic levels"));
  EXPECT_THAT(Refusal("KIT/%23"), HasSubstr("wildcards"));
  EXPECT_THAT(Refusal("%00/1"), HasSubstr("control character"));
  EXPECT_THAT(Refusal("%FF/1"), HasSubstr("UTF-8"));
}

TEST(RobotAddress, IsWrittenAsAWordThatMeansItAlone) {
  for (const auto& [robot, word] : kWords) {
    EXPECT_EQ(robot.ToString(), word);
    EXPECT_TRUE(IsWrittenOtherwise(robot)) << word;
    EXPECT_EQ(*ParseRobotAddress(word), robot) << word;
  }
  EXPECT_FALSE(IsWrittenOtherwise(kRobot));
  EXPECT_EQ(ParseRobotAddress("50%/%zz%4")->ToString(), "50%25/%25zz%254") << "no escape";
}

TEST(ParseRobotAddress, WantsExactlyTwoLevels) {
  for (const std::string_view text : {"", "KIT", "KIT/0001/state", "KIT//0001", "///"}) {
    EXPECT_THAT(Refusal(text), HasSubstr("name a robot as manufacturer/serialNumber")) << text;
  }
}

TEST(ParseRobotAddress, RefusesWhatWouldReachAnotherRobot) {
  constexpr std::pair<std::string_view, std::string_view> kCases[] = {
      {"/0001", "target '/0001': its manufacturer is refused: it is empty"},
      {"KIT/", "target 'KIT/': its serial number is refused: it is empty"},
      {"/", "target '/': its manufacturer is refused: it is empty"},
      {"KIT/+",
       "target 'KIT/+': its serial number is refused: + and # are wildcards and cannot be part of "
       "a name"},
      {"#/0001",
       "target '#/0001': its manufacturer is refused: + and # are wildcards and cannot be part of "
       "a name"},
      {"KIT/00+1",
       "target 'KIT/00+1': its serial number is refused: + and # are wildcards and "
       "cannot be part of a name"},
      {"$SYS/1", "target '$SYS/1': its manufacturer is refused: $ is reserved for the broker"},
      {"KIT/a$", "target 'KIT/a$': its serial number is refused: $ is reserved for the broker"},
      {"KIT/a\n",
       "target 'KIT/a\\n': its serial number is refused: it contains a control "
       "character"},
      {"KIT/\x7F",
       "target 'KIT/\\x7f': its serial number is refused: it contains a control "
       "character"},
      {"KIT/\xFF", "target 'KIT/\\xff': its serial number is refused: it is not valid UTF-8"},
  };
  for (const auto& [text, sentence] : kCases) EXPECT_EQ(Refusal(text), sentence);
}

TEST(HasRecommendedCharacters, AreThoseOfTheSpecification) {
  EXPECT_TRUE(HasRecommendedCharacters("AZaz09_.:-"));
  EXPECT_TRUE(HasRecommendedCharacters(""));
  for (const std::string_view text : {"a b", "ä", "a/b", "a,b", "@", "[", "`", "{"}) {
    EXPECT_FALSE(HasRecommendedCharacters(text)) << text;
  }
}

TEST(TopicFor, FollowsTheVersion) {
  EXPECT_EQ(Topic({}, Version::k110), "uagv/v1/KIT/0001/instantActions");
  EXPECT_EQ(Topic({}, Version::k200), "uagv/v2/KIT/0001/instantActions");
  EXPECT_EQ(Topic({}, Version::k210), "uagv/v2/KIT/0001/instantActions");
  EXPECT_EQ(Topic({}, Version::k300), "vda5050/v3/KIT/0001/instantActions");
}

TEST(TopicFor, TakesAnotherInterfaceName) {
  EXPECT_EQ(Topic({.interface_name = "fts"}, Version::k210), "fts/v2/KIT/0001/instantActions");
  EXPECT_EQ(Topic({.interface_name = "site/a"}), "site/a/v3/KIT/0001/instantActions");
}

TEST(TopicFor, FillsATemplate) {
  const auto topic = [](std::string text) { return Topic({.topic_template = std::move(text)}); };
  EXPECT_EQ(topic("{topic}/{serial}/{manufacturer}"), "instantActions/0001/KIT");
  EXPECT_EQ(topic("x/v1/{manufacturer}/{serial}/{topic}"), "x/v1/KIT/0001/instantActions");
  EXPECT_EQ(topic("{manufacturer}-{serial}/{topic}"), "KIT-0001/instantActions");
  EXPECT_EQ(topic("{manufacturer}/{serial}/{serial}/{topic}"), "KIT/0001/0001/instantActions");
}

TEST(TopicFor, TakesThePrefixThatACloudBrokerForces) {
  const std::string rest = "/{manufacturer}/{serial}/{topic}";
  EXPECT_EQ(Topic({.topic_template = rest}), "/KIT/0001/instantActions");
  EXPECT_EQ(Topic({.topic_template = "$aws" + rest}), "$aws/KIT/0001/instantActions");
}

TEST(TopicFor, FillsNoPlaceholderInsideAName) {
  EXPECT_EQ(Topic({}, Version::k300, {"{serial}", "7"}), "vda5050/v3/{serial}/7/instantActions");
}

TEST(TopicFor, RefusesATemplateThatDoesNotTellRobotsApart) {
  EXPECT_EQ(Topic({.topic_template = "x/{manufacturer}/{topic}"}),
            "topic template 'x/{manufacturer}/{topic}' lacks {serial}: every robot would get the "
            "message");
  EXPECT_THAT(Topic({.topic_template = ""}), HasSubstr("lacks"));
}

TEST(TopicFor, RefusesAPlaceholderThatThereIsNot) {
  const std::string all = "{manufacturer}/{serial}/{topic}/";
  for (const std::string_view last : {"{robot}", "{}", "{", "{Serial}", "{{serial}}"}) {
    EXPECT_THAT(Topic({.topic_template = all + std::string(last)}),
                HasSubstr("is not a placeholder"))
        << last;
  }
}

TEST(TopicFor, RefusesATopicThatMqttDoesNotAllow) {
  for (const std::string_view interface_name :
       {"+", "#", "a+b", "a//b", "a/", "a/$b", "a\nb", "a\xFF", "$+", "$a#", "$$"}) {
    EXPECT_THAT(Topic({.interface_name = std::string(interface_name)}), HasSubstr("is refused"))
        << interface_name;
  }
}

TEST(TopicFor, RefusesATopicThatIsTooLong) {
  const std::size_t rest = std::string_view("vda5050/v3//7/instantActions").size();
  EXPECT_EQ(Topic({}, Version::k300, {std::string(65'535 - rest, 'x'), "7"}).size(), 65'535U);
  EXPECT_EQ(Topic({}, Version::k300, {std::string(65'536 - rest, 'x'), "7"}),
            "topic of 65536 bytes: MQTT allows 65535");
}

}  // namespace
}  // namespace fleetpub::vda5050
