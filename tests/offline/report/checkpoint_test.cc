#include "dataset/error.h"
#include "dataset/files.h"
#include "report/checkpoint_json.h"
#include "report/residual_file.h"
#include "support.h"

namespace raygrid {
namespace {

Checkpoint ExampleCheckpoint() {
  Checkpoint checkpoint;
  Dataset& again = checkpoint.refined_features.emplace();
  again.image_size = {640, 480};
  again.images = {{"a.png", {{0, 3, 4, {1.0 / 3, 2}}}}, {"b.png", {}}};
  HeldOutResiduals held_out;
  held_out.alone = {{{"a.png", 0, 3, 4, {1, 2}, {0.1, -1}}}};
  held_out.with_deformation = {{{"a.png", 0, 5, 4, {3, 2}, {0.2, -2}}}};
  checkpoint.trials = {{2, {80.0 / 3}, true, held_out}};
  return checkpoint;
}

TEST(Checkpoint, IsReadBackExactly) {
  const std::string text = FormatCheckpoints({ExampleCheckpoint(), {}}, "cafe");
  const TemporaryFolder folder;
  WriteFile(folder / "resume.json", text);
  const std::vector<Checkpoint> read =
      ReadCheckpoints(folder / "resume.json", "cafe");
  EXPECT_EQ(FormatCheckpoints(read, "cafe"), text);
  ASSERT_EQ(read.size(), 2u);
  const Checkpoint& first = read[0];
  ASSERT_TRUE(first.refined_features);
  EXPECT_EQ(first.refined_features->images[0].features[0].pixel.x(), 1.0 / 3);
  EXPECT_EQ(first.trials[0].knot_spacings_px.front(), 80.0 / 3);
  EXPECT_TRUE(first.trials[0].rigid_boards);
  EXPECT_EQ(first.trials[0].held_out.alone[0][0].error_px.y(), -1);
  EXPECT_EQ(first.trials[0].held_out.with_deformation[0][0].error_px.y(), -2);
}

TEST(Checkpoint, OfOtherInputsOrMalformedIsRefused) {
  const std::string text = FormatCheckpoints({ExampleCheckpoint(), {}}, "cafe");
  const TemporaryFolder folder;
  const std::string path = folder / "resume.json";
  EXPECT_THROW(ReadCheckpoints(path, "cafe"), InputError);
  WriteFile(path, text);
  EXPECT_THROW(ReadCheckpoints(path, "beef"), InputError);
  for (const std::string& broken :
       {text.substr(0, text.size() / 2), std::string("{}"), std::string("[]"),
        std::string(R"({"raygrid_resume": 4, "inputs": "cafe"})"),
        std::string(
            R"({"raygrid_resume": 4, "inputs": "cafe", "cameras": []})")}) {
    WriteFile(path, broken);
    EXPECT_THROW(ReadCheckpoints(path, "cafe"), InputError) << broken;
  }
}

TEST(Checkpoint, ThatWasAlteredIsRefused) {
  const std::string text = FormatCheckpoints({ExampleCheckpoint(), {}}, "cafe");
  const TemporaryFolder folder;
  const std::string path = folder / "resume.json";
  for (const char* number : {"-1.0", "3,4,1.0", "0.3333", "640"}) {
    std::string altered = text;
    altered.replace(altered.find(number), 1, "2");
    ASSERT_NE(altered, text) << number;
    WriteFile(path, altered);
    ExpectError(ExitCode::kInvalidInput, {"resume.json", "was modified"},
                [&] { ReadCheckpoints(path, "cafe"); });
  }
}

// A table of what a calibration cannot have left is refused by its length.
TEST(Residuals, OfMoreRowsThanACalibrationLeaves) {
  const TemporaryFolder folder;
  const std::string path = folder / "residuals.csv";
  std::string text = "set,image,board,column,row,x,y,dx,dy\n";
  for (size_t k = 0; k <= kMaxResidualRows; ++k)
    text += "rejected,a,0,0,0,1,1,0,0\n";
  WriteFile(path, text);
  ExpectError(ExitCode::kInvalidInput,
              {"residuals.csv, line 2000002", "2000000 rows"},
              [&] { ReadResiduals(path); });
}

}  // namespace
}  // namespace raygrid
