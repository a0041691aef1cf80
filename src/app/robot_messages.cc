#include "app/robot_messages.h"

#include <span>
#include <utility>
#include <vector>

#include "base/time.h"

namespace fleetpub::app {
namespace {

using vda5050::Dialect;
using vda5050::InstantAction;
using vda5050::RobotAddress;

class InstantMessage final : public RobotMessage {
 public:
  InstantMessage(InstantAction action, bool has_given_id)
      : action_(std::move(action)), has_given_id_(has_given_id) {
    if (!has_given_id_) action_.id = vda5050::MakeActionId(nullptr);
  }

  [[nodiscard]] Result<message::Command> Build(
      const RobotAddress& robot, const Dialect& dialect,
      std::optional<std::uint32_t> header_id) const override {
    return vda5050::BuildInstantActions(robot, dialect, {&action_, 1}, header_id);
  }

  [[nodiscard]] vda5050::PreflightFindings Check(const RobotAddress& robot, const Dialect& dialect,
                                                 const vda5050::KnownRobot& known) const override {
    InstantAction named = action_;
    named.type = vda5050::NameIn(dialect.version, named.type);
    const auto command = vda5050::BuildInstantActions(robot, dialect, {&named, 1});
    const std::size_t bytes =
        command ? command->payload.Render(0, base::WallTime::clock::now()).size() : 0;
    return vda5050::CheckRobot(robot, dialect, {&named, 1}, known, bytes);
  }

  [[nodiscard]] Result<std::unique_ptr<message::ResponseTracker>> Track(
      const RobotAddress& robot, const Dialect& dialect, vda5050::WaitFor wait_for) const override {
    return vda5050::TrackInstantAction(robot, dialect, action_, wait_for);
  }

  [[nodiscard]] bool IsOnlyStartPause() const override {
    return vda5050::IsOnlyStartPause({&action_, 1});
  }
  [[nodiscard]] bool NeedsFactsheet() const override {
    return vda5050::NeedsFactsheet({&action_, 1});
  }
  [[nodiscard]] bool IsAlikeForAll() const override { return true; }

  [[nodiscard]] Status Prepare(const vda5050::ListedRobot& robot,
                               const std::vector<std::string>& /*brokers*/,
                               std::vector<std::string>& /*notes*/) override {
    const auto& factsheet = robot.second.factsheet;
    if (factsheet && !has_given_id_) action_.id = vda5050::MakeActionId(factsheet.get());
    return {};
  }

 private:
  InstantAction action_;
  bool has_given_id_;
};

class UserMessage final : public RobotMessage {
 public:
  UserMessage(std::string_view topic, std::shared_ptr<const base::JsonDocument> message,
              vda5050::HeaderMismatch on_mismatch)
      : topic_(topic), message_(std::move(message)), on_mismatch_(on_mismatch) {}

  [[nodiscard]] Result<message::Command> Build(
      const RobotAddress& robot, const Dialect& dialect,
      std::optional<std::uint32_t> header_id) const override {
    return vda5050::BuildUserMessage(robot, dialect, topic_, *message_, on_mismatch_, header_id);
  }

  [[nodiscard]] vda5050::PreflightFindings Check(const RobotAddress& robot, const Dialect& dialect,
                                                 const vda5050::KnownRobot& known) const override {
    const auto command = Build(robot, dialect, std::nullopt);
    const std::size_t bytes =
        command ? command->payload.Render(0, base::WallTime::clock::now()).size() : 0;
    const auto actions = topic_ == "instantActions" ? vda5050::ActionsIn(*message_, dialect)
                                                    : std::vector<vda5050::InstantAction>();
    return vda5050::CheckRobot(robot, dialect, actions, known, bytes);
  }

  [[nodiscard]] Result<std::unique_ptr<message::ResponseTracker>> Track(
      const RobotAddress& robot, const Dialect& dialect, vda5050::WaitFor wait_for) const override {
    return vda5050::TrackUserMessage(robot, dialect, topic_, *message_, wait_for);
  }

  [[nodiscard]] bool IsOnlyStartPause() const override {
    return vda5050::IsOnlyStartPause(Actions());
  }
  [[nodiscard]] bool NeedsFactsheet() const override { return vda5050::NeedsFactsheet(Actions()); }

 private:
  // Whatever its version calls them: it is not known yet how the robot is spoken to.
  [[nodiscard]] std::vector<InstantAction> Actions() const {
    if (topic_ != "instantActions") return {};
    Dialect dialect;
    auto actions = vda5050::ActionsIn(*message_, dialect);
    dialect.actions_key = "instantActions";
    return actions.empty() ? vda5050::ActionsIn(*message_, dialect) : actions;
  }

  std::string_view topic_;
  std::shared_ptr<const base::JsonDocument> message_;
  vda5050::HeaderMismatch on_mismatch_;
};

}  // namespace

std::unique_ptr<RobotMessage> MakeInstantMessage(vda5050::InstantAction action, bool has_given_id) {
  return std::make_unique<InstantMessage>(std::move(action), has_given_id);
}

std::unique_ptr<RobotMessage> MakeUserMessage(std::string_view topic,
                                              std::shared_ptr<const base::JsonDocument> message,
                                              vda5050::HeaderMismatch mismatch) {
  return std::make_unique<UserMessage>(topic, std::move(message), mismatch);
}

}  // namespace fleetpub::app
