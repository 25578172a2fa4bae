#include <nlohmann/json.hpp>
#include <string>

#include "evaluation/budget_assessment.h"
#include "report/budget_section.h"
#include "report/result_fields.h"
#include "support.h"

namespace raygrid {
namespace {

ResidualBudget ExampleBudget() {
  ResidualBudget budget;
  budget.num_features = 500;
  budget.num_views = 12;
  budget.rms_px = 0.2;
  budget.noise_px = {0.1, 0.11};
  budget.noise = 0.3;
  budget.large = 0.01;
  for (int k = 0; k < kNumErrorCauses; ++k)
    budget.causes[static_cast<size_t>(k)] = {true,  "",   0.01 * k, 0.0,
                                             0.001, 0.02, false};
  CauseShare& bends =
      budget.causes[static_cast<size_t>(ErrorCause::kDeformation)];
  bends.sequential_share = bends.alone = 0.5;
  bends.is_indistinguishable = true;
  budget.causes[0] = {false, "7 views, at least <8> required"};
  budget.column_delay = 0.04;
  budget.is_column_delay_indistinguishable = false;
  budget.rest = 0.19;
  budget.facts = {"central-generic", 40,  true, true, true, true, false, true,
                  "opencv",          true};
  return budget;
}

bool HasText(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(MakeBudgetJson, IsReadAsItWasWritten) {
  const nlohmann::ordered_json json = ExampleBudget();
  EXPECT_EQ(json["limited_by"], "per-view deformation");
  EXPECT_EQ(json["causes"][2]["cause"], "per-view deformation");
  EXPECT_EQ(json["causes"][2]["fraction"], 0.5);
  EXPECT_EQ(json["causes"][0]["not_observable"],
            "7 views, at least <8> required");
  EXPECT_EQ(nlohmann::ordered_json(json.get<ResidualBudget>()), json);
}

TEST(MakeBudgetJson, SaysWhyNothingIsTold) {
  ResidualBudget budget;
  budget.unobservable_reason = "3 features, at least 200 required";
  const nlohmann::ordered_json json = budget;
  EXPECT_FALSE(json.contains("causes"));
  EXPECT_EQ(json.get<ResidualBudget>().unobservable_reason,
            budget.unobservable_reason);
  EXPECT_EQ(nlohmann::ordered_json(json.get<ResidualBudget>()), json);
}

TEST(MakeBudgetSection, SaysWhatLimitsAndWhatToDo) {
  ResidualBudget budget = ExampleBudget();
  const std::string html = MakeBudgetSection(budget);
  budget.facts.mixed_cameras = false;
  EXPECT_TRUE(HasText(MakeBudgetSection(budget), "Remedy: mount the pattern"));
  EXPECT_TRUE(HasText(html, "<h2>What limits this calibration</h2>"));
  EXPECT_TRUE(HasText(html, "<b>Out-of-plane target deformation"));
  EXPECT_TRUE(HasText(html, "Remedy: calibrate the images of the two"));
  EXPECT_TRUE(HasText(html, "title=\"per-view deformation: 50.0 %\""));
  EXPECT_TRUE(
      HasText(html, "not observable: 7 views, at least &lt;8&gt; required"));
  EXPECT_FALSE(HasText(html, "column"));
}

TEST(MakeBudgetSection, IsASentenceWhereNothingIsTold) {
  ResidualBudget budget;
  budget.unobservable_reason = "3 features, at least 200 required";
  const std::string html = MakeBudgetSection(budget);
  EXPECT_TRUE(HasText(html, "Not observable: 3 features"));
  EXPECT_FALSE(HasText(html, "<table>"));
}

}  // namespace
}  // namespace raygrid
