// Layouts for tests, in few words.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "layout/layout.h"

namespace fleetpub::testing {

inline std::string NodeText(std::string_view id, double x, double y,
                            std::string_view more = R"({"vehicleTypeId":"T"})",
                            std::string_view map = "m") {
  return fmt::format(
      R"({{"nodeId":"{}","mapId":"{}","nodePosition":{{"x":{},"y":{}}},"vehicleTypeNodeProperties":[{}]}})",
      id, map, x, y, more);
}

/// `a-b` with members of its property for T.
inline std::string EdgeText(std::string_view start, std::string_view end,
                            std::string_view more = "", std::string_view suffix = "") {
  return fmt::format(
      R"({{"edgeId":"{0}-{1}{3}","startNodeId":"{0}","endNodeId":"{1}","vehicleTypeEdgeProperties":)"
      R"([{{"vehicleTypeId":"T","rotationAllowed":false{2}}}]}})",
      start, end, more.empty() ? "" : "," + std::string(more), suffix);
}

/// Members of one layout: its arrays are given without their brackets.
inline std::string LayoutText(const std::vector<std::string>& nodes,
                              const std::vector<std::string>& edges, std::string_view stations = "",
                              std::string_view id = "hall") {
  return fmt::format(
      R"({{"layoutId":"{}","layoutVersion":"1","nodes":[{}],"edges":[{}],"stations":[{}]}})", id,
      base::Join(nodes, ","), base::Join(edges, ","), stations);
}

inline std::string FileText(const std::vector<std::string>& layouts) {
  return fmt::format(
      R"({{"metaInformation":{{"projectIdentification":"p","creator":"c",)"
      R"("exportTimestamp":"2026-04-15T11:40:03.12Z","lifVersion":"1.0.0"}},"layouts":[{}]}})",
      base::Join(layouts, ","));
}

inline std::string FileText(const std::vector<std::string>& nodes,
                            const std::vector<std::string>& edges, std::string_view stations = "") {
  return FileText({LayoutText(nodes, edges, stations)});
}

inline layout::ReadSite Read(const std::string& text) {
  auto read = layout::ReadLayout(text);
  EXPECT_TRUE(read) << (read ? "" : read.error().message);
  return read ? *std::move(read) : layout::ReadSite{};
}

}  // namespace fleetpub::testing
