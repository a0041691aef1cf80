// What holds for any input, tried with random ones. A failure prints the smallest counterexample
// and how to repeat it.
#include <gmock/gmock.h>
#include <rapidcheck.h>

#include <algorithm>

#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "vda5050/robot_address.h"

namespace fleetpub {
namespace {

rc::Gen<std::string> Bytes() { return rc::gen::arbitrary<std::string>(); }

// A name that may stand in a topic level, with some letters of more than a byte.
rc::Gen<std::string> LevelName() {
  const auto letter =
      rc::gen::element<std::string>("a", "Z", "0", "_", ".", ":", "-", " ", "ü", "🤖");
  return rc::gen::map(
      rc::gen::nonEmpty(rc::gen::container<std::vector<std::string>>(letter)),
      [](const std::vector<std::string>& letters) { return base::Join(letters, ""); });
}

TEST(AnyRobotAddress, IsParsedFromItsText) {
  EXPECT_TRUE(rc::check([] {
    const vda5050::RobotAddress robot{*LevelName(), *LevelName()};
    const auto parsed = vda5050::ParseRobotAddress(robot.ToString());
    RC_ASSERT(parsed.has_value());
    RC_ASSERT(*parsed == robot);
  }));
}

TEST(AnyText, IsRefusedAsATargetOrNamesTwoLevels) {
  EXPECT_TRUE(rc::check([] {
    const std::string text = *Bytes();
    const auto robot = vda5050::ParseRobotAddress(text);
    if (!robot) return;
    RC_ASSERT(robot->ToString() == text);
    RC_ASSERT(text.find_first_of("+#$") == std::string::npos);
    RC_ASSERT(base::Split(text, '/').size() == 2U);
  }));
}

TEST(AnyText, ComesBackFromAJsonString) {
  EXPECT_TRUE(rc::check([] {
    const std::string text = *LevelName() + base::Printable(*Bytes());
    const auto parsed = base::ParseJson(base::JsonString(text));
    RC_ASSERT(parsed.has_value());
    RC_ASSERT(base::ViewOf(*parsed) == text);
  }));
}

TEST(AnyText, IsPrintedSafely) {
  EXPECT_TRUE(rc::check([] {
    const std::string shown = base::Printable(*Bytes());
    RC_ASSERT(base::IsUtf8(shown));
    RC_ASSERT(base::Printable(shown) == shown);
  }));
}

TEST(AnyText, IsParsedAsJsonOrRefusedWithASentence) {
  EXPECT_TRUE(rc::check([] {
    const auto letters = *rc::gen::container<std::string>(
        rc::gen::elementOf(std::string("[]{}\",:\\u0eE+-.d8 \n\xC3\xED\xA0")));
    const auto document = base::ParseJson(letters);
    if (!document) {
      RC_ASSERT(!document.error().message.empty());
      return;
    }
    const std::string text = base::ToJson(*document);
    RC_ASSERT(base::IsUtf8(text));
    RC_ASSERT(base::ParseJson(text).has_value());
  }));
}

TEST(AnyName, IsFoundByItsPointerToken) {
  EXPECT_TRUE(rc::check([] {
    const std::string name =
        *rc::gen::container<std::string>(rc::gen::elementOf(std::string("ab~/01")));
    rapidjson::Document document(rapidjson::kObjectType);
    rapidjson::Value key(name, document.GetAllocator());
    document.AddMember(key, rapidjson::Value(42), document.GetAllocator());
    const std::string text = "/" + base::PointerToken(name);
    const rapidjson::Pointer pointer(text.c_str(), text.size());
    RC_ASSERT(pointer.IsValid());
    const rapidjson::Value* found = pointer.Get(document);
    RC_ASSERT(found != nullptr && found->GetInt() == 42);
  }));
}

TEST(AnyMillisecond, ComesBackFromItsTimestamp) {
  EXPECT_TRUE(rc::check([] {
    constexpr std::int64_t kReach = 9'000'000'000'000;  // the clock reaches from 1677 to 2262
    const base::WallTime time{std::chrono::milliseconds(*rc::gen::inRange(-kReach, kReach))};
    const std::string text = base::FormatTimestamp(time);
    RC_ASSERT(text.size() == 24U);
    RC_ASSERT(base::ParseDateTime(text) == time);
  }));
}

TEST(AnyTwoWords, AreAsFarFromEachOtherEitherWay) {
  EXPECT_TRUE(rc::check([] {
    const auto word = rc::gen::container<std::string>(rc::gen::elementOf(std::string("abAB")));
    const std::string a = *word;
    const std::string b = *word;
    const int distance = base::EditDistance(a, b);
    RC_ASSERT(distance == base::EditDistance(b, a));
    RC_ASSERT((distance == 0) == base::EqualsIgnoringCase(a, b));
    RC_ASSERT(distance <= static_cast<int>(std::max(a.size(), b.size())));
  }));
}

}  // namespace
}  // namespace fleetpub
