#include "dataset/robot_poses.h"

#include "support.h"

namespace raygrid {
namespace {

// A rotation by 90 degrees about z, at (1, 2, 3).
constexpr const char* kQuaternion = "1 2 3 0 0 0.70710678 0.70710678";
constexpr const char* kMatrix = "0 -1 0 1  1 0 0 2  0 0 1 3  0 0 0 1";

void ExpectThePose(const RobotPoses& robot, const std::string& label) {
  ASSERT_EQ(robot.poses.size(), 1u);
  EXPECT_EQ(robot.poses[0].label, label);
  EXPECT_EQ(robot.num_normalized, 0);
  const Pose& pose = robot.poses[0].pose;
  EXPECT_NEAR(
      (pose * Eigen::Vector3d::UnitX() - Eigen::Vector3d(1, 3, 3)).norm(), 0,
      1e-7);
}

RobotPoses Parse(const std::string& text,
                 const RobotPoseOptions& options = {}) {
  return ParseRobotPoses("robot.txt", text, options);
}

std::string ErrorOfText(const std::string& text) {
  try {
    Parse(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

#define EXPECT_SAYS(text, part) \
  EXPECT_NE((text).find(part), std::string::npos) << (text)

TEST(RobotPoses, AreReadFromAllFormats) {
  const std::string q = kQuaternion, m = kMatrix;
  ExpectThePose(Parse("# TUM\na.png " + q + "\n"), "a.png");
  ExpectThePose(Parse("12.5 " + q), "12.5");
  ExpectThePose(Parse(q + "\r\n"), "");
  ExpectThePose(Parse("a.png " + m + "\n"), "a.png");
  ExpectThePose(Parse("0 -1 0 1 1 0 0 2 0 0 1 3\n"), "");
  ExpectThePose(Parse("a.png\n0 -1 0 1\n1 0 0 2\n0, 0, 1, 3\n0 0 0 1\n"),
                "a.png");
  ExpectThePose(Parse("image,qw,qx,qy,qz,tx,ty,tz\n"
                      "a.png,0.70710678,0,0,0.70710678,1,2,3\n"),
                "a.png");
  ExpectThePose(Parse("%time,field.header.seq,field.header.frame_id,"
                      "field.pose.position.x,field.pose.position.y,"
                      "field.pose.position.z,field.pose.orientation.x,"
                      "field.pose.orientation.y,field.pose.orientation.z,"
                      "field.pose.orientation.w\n"
                      "12,7,base,1,2,3,0,0,0.70710678,0.70710678\n"),
                "12");
  ExpectThePose(
      Parse("header.stamp.sec,header.stamp.nanosec,transform.translation.x,"
            "transform.translation.y,transform.translation.z,"
            "transform.rotation.x,transform.rotation.y,transform.rotation.z,"
            "transform.rotation.w\n"
            "12,500000000,1,2,3,0,0,0.70710678,0.70710678\n"),
      "12.500000000");
}

TEST(RobotPoses, AreConverted) {
  const std::string text = std::string("a.png ") + kQuaternion;
  EXPECT_NEAR(Parse(text, {1e-3, false}).poses[0].pose.translation.x(), 1e-3,
              1e-12);
  const Pose pose = Parse(text).poses[0].pose;
  const Pose inverse = Parse(text, {1, true}).poses[0].pose;
  EXPECT_LT((pose * inverse).translation.norm(), 1e-7);
  // 0.5 % off a unit length is reported, 2 % refused.
  EXPECT_EQ(Parse("a 1 2 3 0 0 0 1.005\n").num_normalized, 1);
}

TEST(RobotPoses, FaultsAreNamed) {
  EXPECT_SAYS(ErrorOfText("a 1 2 3 0 0 0 1.02\n"), "line 1: the quaternion");
  EXPECT_SAYS(ErrorOfText("a 1 2 3 0 0 0 0\n"), "100 %");
  EXPECT_SAYS(ErrorOfText("a 1 2 3 0 0 0 nan\n"), "'nan'");
  EXPECT_SAYS(ErrorOfText("1 0 0 0 0 1 0 0 0 0 -1 0\n"), "reflection");
  EXPECT_SAYS(ErrorOfText("1 0 0 0 0 1.1 0 0 0 0 1 0\n"), "10 %");
  EXPECT_SAYS(ErrorOfText("1 0 0 0 0 1 0 0 0 0 1 0 5 6 7 1\n"), "last row");
  EXPECT_SAYS(ErrorOfText("a.png\n1 0 0 0\n0 1 0 0\n"), "2 rows of 4");
  EXPECT_SAYS(ErrorOfText("# a\nname x y z qx qy qz qw\na 1 2 3 0 0 0 2\n"),
              "line 3");
  EXPECT_SAYS(ErrorOfText("1 2 3\n"), "3 fields");
  EXPECT_SAYS(ErrorOfText("# nothing\n"), "no poses");
  // Rows that a spreadsheet leaves empty.
  EXPECT_SAYS(ErrorOfText(" , \n"), "no poses");
  EXPECT_SAYS(ErrorOfText(",,,,\r\nimage,x,y,z,qx,qy,qz,qw\na,1,2,3,0,0,0,2\n"),
              "line 3");
  EXPECT_SAYS(ErrorOfText("image,x,y,z,qx,qy,qz\na,1,2,3,0,0,0\n"),
              "no column for qw");
}

TEST(RobotPoses, AreMatchedWithImages) {
  const std::string q = kQuaternion;
  const auto match = [](const std::string& text,
                        const std::vector<std::string>& images,
                        const MatchingOptions& options = {}) {
    return MatchRobotPoses("robot.txt", Parse(text), images, options);
  };
  MatchedRobotPoses matched =
      match("b " + q + "\na " + q + "\n", {"x/a.png", "x/c.png"});
  EXPECT_EQ(matched.rule, "name");
  EXPECT_EQ(matched.by_image.size(), 1u);
  EXPECT_EQ(matched.by_image.count("x/a.png"), 1u);
  // Numbers with a fraction are no names with an extension.
  matched = match("10.00 1 2 3 0 0 0 1\n10.01 2 2 3 0 0 0 1\n10.5 " + q,
                  {"10.005.png", "10.3.png", "10500000000.png"});
  EXPECT_EQ(matched.rule, "time");
  EXPECT_EQ(matched.by_image.size(), 1u);
  EXPECT_NEAR(matched.by_image["10.005.png"].translation.x(), 1.5, 1e-9);
  matched =
      match("10.00 1 2 3 0 0 0 1\n", {"a.png"}, {0.02, {{"a.png", 10.01}}});
  EXPECT_EQ(matched.by_image.size(), 1u);
  matched = match(q + "\n1 2 4 0 0 0 1\n", {"b", "a"});
  EXPECT_EQ(matched.rule, "order");
  EXPECT_NEAR(matched.by_image["b"].translation.z(), 4, 1e-9);
  EXPECT_THROW(match(q + "\n", {"a", "b"}), InputError);
  EXPECT_THROW(match("x " + q + "\n", {"a"}), InputError);
  EXPECT_THROW(match("1 " + q + "\n", {"5.png"}), InputError);
  EXPECT_THROW(match("a " + q + "\na " + q, {"a"}), InputError);
  EXPECT_THROW(match("a.png " + q, {"s1/a.png", "s2/a.png"}), InputError);
}

TEST(RobotPoses, TimesHaveAnyUnit) {
  double seconds = 0;
  for (const char* label : {"1700000000.5", "1700000000500", "1700000000500000",
                            "1700000000500000000.png"}) {
    ASSERT_TRUE(ParseTime(label, &seconds));
    EXPECT_NEAR(seconds, 1700000000.5, 1e-5) << label;
  }
  EXPECT_FALSE(ParseTime("im1.png", &seconds));
}

}  // namespace
}  // namespace raygrid
