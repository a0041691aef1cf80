#include "vda5050/reports/robot_errors.h"

#include <gmock/gmock.h>

#include <array>

namespace fleetpub::vda5050 {
namespace {

using ::testing::HasSubstr;

constexpr std::string_view kId = "3f2c8a2e-7b51-4c4e-9d0a-5a4f0f6d1c22";
constexpr std::string_view kOther = "00000000-7b51-4c4e-9d0a-5a4f0f6d1c22";
constexpr std::array<std::uint32_t, 2> kHeaderIds = {18, 19};

RobotError Error(std::string type, std::vector<ErrorReference> references) {
  return {.type = std::move(type), .references = std::move(references)};
}

Attribution Of(std::string type, std::vector<ErrorReference> references) {
  return Attribute(
      Error(std::move(type), std::move(references)),
      {.topic = "instantActions", .id_key = "actionId", .id = kId, .header_ids = kHeaderIds});
}

TEST(Attribute, KnowsOurActionIdUnderAnyKey) {
  // VDA 5050's own, libVDA5050++'s, ros_amr_interop's, and one that nobody has thought of.
  for (const std::string key : {"actionId", "action.actionId", "order.action.actionId", "action_id",
                                "instantActionId", "headerId", "what", ""}) {
    EXPECT_EQ(Of("anything", {{"topic", "order"}, {key, std::string(kId)}}), Attribution::kItem)
        << key;
  }
}

TEST(Attribute, KnowsAShortActionIdOnlyWhereItCanBeOne) {
  const auto of = [](std::string key) {
    return Attribute(
        Error("E", {{std::move(key), "18"}}),
        {.topic = "instantActions", .id_key = "actionId", .id = "18", .header_ids = {}});
  };
  EXPECT_EQ(of("actionId"), Attribution::kItem);
  EXPECT_EQ(of("action_id"), Attribution::kItem);
  EXPECT_EQ(of("id"), Attribution::kItem);
  for (const std::string key : {"headerId", "header.headerId", "orderId", "order_id", "nodeId",
                                "edgeId", "sequenceId", "mapId", "orderUpdateId"}) {
    EXPECT_EQ(of(key), Attribution::kOther) << key;
  }
}

TEST(Attribute, NeverGoesByTheTypeAlone) {
  for (const std::string type : {"NO_ORDER_TO_CANCEL", "noOrderToCancel", "INVALID_INSTANT_ACTION",
                                 "instantActionError", "validationError"}) {
    EXPECT_EQ(Of(type, {{"actionId", std::string(kOther)}}), Attribution::kOther) << type;
    EXPECT_EQ(Of(type, {}), Attribution::kUnnamed) << type;
  }
}

TEST(Attribute, TakesHeaderIdAndTopicForProbablyOurs) {
  // vda-5050-lib: a message whose header it does not like.
  EXPECT_EQ(Of("validationError", {{"topic", "instantActions"}, {"headerId", "18"}}),
            Attribution::kHeaderId);
  EXPECT_EQ(Of("orderError", {{"topic", "uagv/v2/KIT/0001/instantActions"}, {"headerId", "19"}}),
            Attribution::kHeaderId);
  EXPECT_EQ(Of("x", {{"Topic", "instantAction"}, {"header.headerId", "18"}}),
            Attribution::kHeaderId);
}

TEST(Attribute, TakesAHeaderIdWithoutTopicOnlyForAnErrorAboutAMessage) {
  for (const std::string type :
       {"InvalidHeader", "validationError", "VALIDATION_FAILURE", "invalid_header"}) {
    EXPECT_EQ(Of(type, {{"header.headerId", "18"}}), Attribution::kHeaderId) << type;
  }
  EXPECT_EQ(Of("orderError", {{"headerId", "18"}}), Attribution::kOther);
}

TEST(Attribute, LeavesOthersHeaderIdsAlone) {
  EXPECT_EQ(Of("validationError", {{"topic", "instantActions"}, {"headerId", "17"}}),
            Attribution::kOther);
  EXPECT_EQ(Of("validationError", {{"topic", "order"}, {"headerId", "18"}}), Attribution::kOther);
  EXPECT_EQ(Of("validationError", {{"topic", "instantActions"}, {"nodeId", "18"}}),
            Attribution::kOther);
  // Another controller's action that happens to have our header id.
  EXPECT_EQ(
      Of("validationError",
         {{"topic", "instantActions"}, {"headerId", "18"}, {"actionId", std::string(kOther)}}),
      Attribution::kOther);
}

TEST(Attribute, CallsAnErrorWithoutAnyIdUnnamed) {
  // libVDA5050++'s ActionBlockingTypeMismatch names no id whatsoever.
  EXPECT_EQ(Of("ActionBlockingTypeMismatch", {{"action.blockingType", "NONE"}}),
            Attribution::kUnnamed);
  EXPECT_EQ(Of("lowBattery", {{"nodeId", "n1"}}), Attribution::kOther);
}

TEST(Attribute, KnowsTheActionsNodesAndEdgesOfAnOrder) {
  const std::vector<ErrorReference> parts = {
      {"nodeId", "n-1"}, {"edgeId", "e-1"}, {"actionId", "a-1"}};
  const auto of = [&](std::vector<ErrorReference> references) {
    return Attribute(Error("E", std::move(references)), {.topic = "order",
                                                         .id_key = "orderId",
                                                         .id = "o-7",
                                                         .header_ids = kHeaderIds,
                                                         .update_id = 2,
                                                         .parts = parts});
  };
  for (const ErrorReference& part : parts) EXPECT_EQ(of({part}), Attribution::kPart) << part.key;
  EXPECT_EQ(of({{"order.nodes.node_id", "n-1"}}), Attribution::kPart);
  EXPECT_EQ(of({{"nodeId", "n-2"}}), Attribution::kOther);
  EXPECT_EQ(of({{"nodeId", "e-1"}}), Attribution::kOther);
  EXPECT_EQ(of({{"nodeId", "n-1"}, {"orderId", "o-1"}}), Attribution::kOther);
}

TEST(RelatedErrors, AreThoseThatAreNew) {
  const SentItem item{.topic = "order", .id_key = "orderId", .id = "o-7", .header_ids = {}};
  const RobotError old{.type = "E", .description = "d", .references = {{"orderId", "o-7"}}};
  RelatedErrors errors;
  errors.Remember({old}, false);
  RobotError grown = old;
  grown.level = "FATAL";  // still the same
  EXPECT_EQ(errors.Add({grown}, item), Attribution::kOther);
  EXPECT_EQ(errors.Text(), "");
  for (const RobotError& other :
       {RobotError{.type = "F", .description = "d", .references = {{"orderId", "o-7"}}},
        RobotError{.type = "E", .description = "e", .references = {{"orderId", "o-7"}}},
        RobotError{.type = "E", .description = "d", .references = {{"id", "o-7"}}}}) {
    EXPECT_EQ(errors.Add({grown, other}, item), Attribution::kItem) << other.type;
  }
  EXPECT_TRUE(errors.AreOurs());
}

TEST(RelatedErrors, SayWhenNoStateFromBeforeIsKnown) {
  const std::vector<RobotError> unnamed = {{.type = "orderUpdateError"}};
  for (const bool is_known : {true, false}) {
    RelatedErrors errors;
    errors.Remember({}, !is_known);  // a retained one does not tell all
    EXPECT_EQ(errors.Add(unnamed, {.topic = "order", .id_key = "orderId", .id = "o-7"}),
              Attribution::kUnnamed);
    EXPECT_FALSE(errors.AreOurs());
    EXPECT_THAT(errors.Text(), HasSubstr("possibly related: orderUpdateError"));
    EXPECT_EQ(errors.Text().find("before") == std::string::npos, is_known);
  }
}

TEST(FormatError, HasTypeDescriptionAndHint) {
  EXPECT_EQ(FormatError({.type = "noOrderToCancel", .description = "no order", .hint = "send one"}),
            "noOrderToCancel: no order; hint: send one");
  EXPECT_EQ(FormatError({.type = "E"}), "E");
  EXPECT_EQ(FormatError({.description = "lost"}), "error: lost");
}

TEST(FormatError, IsOneShortLineThatMovesNoCursor) {
  const auto told =
      FormatError({.type = "E\x1b[2J", .description = std::string(10'000, 'x') + "\n"});
  EXPECT_LT(told.size(), 600U);
  EXPECT_EQ(told.find_first_of("\x1b\n"), std::string::npos);
}

TEST(Attribute, KnowsAnOrderByItsIdAndItsUpdate) {
  const auto of = [](std::vector<ErrorReference> references) {
    return Attribute(Error("orderError", std::move(references)), {.topic = "order",
                                                                  .id_key = "orderId",
                                                                  .id = "o-7",
                                                                  .header_ids = kHeaderIds,
                                                                  .update_id = 2});
  };
  EXPECT_EQ(of({{"orderId", "o-7"}}), Attribution::kItem);
  EXPECT_EQ(of({{"orderId", "o-7"}, {"orderUpdateId", "2"}}), Attribution::kItem);
  EXPECT_EQ(of({{"orderId", "o-7"}, {"orderUpdateId", "1"}}), Attribution::kOther);
  EXPECT_EQ(of({{"orderId", "o-6"}, {"orderUpdateId", "2"}}), Attribution::kOther);
  // What the robot has, beside what it refuses.
  EXPECT_EQ(
      of({{"order.orderId", "o-7"}, {"order.orderUpdateId", "2"}, {"state.orderUpdateId", "5"}}),
      Attribution::kItem);
  EXPECT_EQ(of({{"orderId", "o-7"}, {"activeOrderId", "o-1"}}), Attribution::kItem);
  EXPECT_EQ(of({{"topic", "orders"}, {"headerId", "18"}}), Attribution::kHeaderId);
  EXPECT_EQ(of({{"topic", "instantActions"}, {"headerId", "18"}}), Attribution::kOther);
}

}  // namespace
}  // namespace fleetpub::vda5050
