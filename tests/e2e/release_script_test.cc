// What scripts/release refuses, in a repository with no more than it looks at.
#include <gmock/gmock.h>

#include "support/process.h"
#include "support/temporary_folder.h"

namespace fleetpub::testing {
namespace {

using ::testing::HasSubstr;

class ReleaseScript : public ::testing::Test {
 protected:
  ReleaseScript() {
    folder_.Write("CMakeLists.txt", "project(fleetpub VERSION 7.8.9 LANGUAGES CXX)\n");
    folder_.Write("CHANGELOG.md", "# Changelog\n\n## Unreleased\n\n- one\n\n## 7.8.8\n\n- two\n");
    Shell("mkdir scripts && cp " FLEETPUB_SOURCE_DIR "/scripts/release scripts && git init -q");
    Commit();
  }
  Finished Shell(const std::string& script) const {
    return testing::Run({.arguments = {"sh", "-ec", script}, .folder = folder_.path().string()});
  }
  void Commit() const {
    const Finished commit =
        Shell("git add -A && git -c user.name=ann -c user.email=ann@example.org commit -qm change");
    EXPECT_EQ(commit.exit_code, 0) << commit.errors;
  }
  void ExpectRefusal(const std::string& mode, const std::string& reason) const {
    const Finished release = Shell("scripts/release " + mode);
    EXPECT_NE(release.exit_code, 0);
    EXPECT_THAT(release.errors, HasSubstr(reason));
    EXPECT_EQ(Shell("test ! -e build").exit_code, 0);
  }

  TemporaryFolder folder_;
};

TEST_F(ReleaseScript, RefusesATreeWithChanges) {
  folder_.Write("new.txt", "");
  for (const char* mode : {"", "--draft", "--check"}) ExpectRefusal(mode, "new.txt");
}

TEST_F(ReleaseScript, RefusesACommitWithoutATag) { ExpectRefusal("", "git tag v7.8.9"); }

TEST_F(ReleaseScript, RefusesTheTagOfAnotherVersion) {
  Shell("git tag v7.8.8");
  ExpectRefusal("", "v7.8.8");
}

TEST_F(ReleaseScript, RefusesAVersionThatTheChangelogDoesNotKnow) {
  Shell("git tag v7.8.9");
  ExpectRefusal("", "CHANGELOG.md has no '## 7.8.9'");
}

// It goes as far as to build, which here is nothing.
TEST_F(ReleaseScript, TakesATagThatTheChangelogKnows) {
  folder_.Write("CHANGELOG.md", "# Changelog\n\n## Unreleased\n\n## 7.8.9 - 2026-01-02\n\n- one\n");
  Commit();
  Shell("git tag v7.8.9");
  EXPECT_THAT(Shell("scripts/release").errors, HasSubstr("scripts/package"));
}

}  // namespace
}  // namespace fleetpub::testing
