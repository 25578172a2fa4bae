#include "initialization/triplet_selection.h"

#include <algorithm>
#include <bitset>
#include <random>
#include <set>

#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

constexpr int kMaxTries = 100000;
constexpr size_t kMinOverlap = 150;  // lattice pixels
constexpr size_t kMaxRefined = 48;
constexpr size_t kMaxMatches = 200;  // per solution

// Bit set of the lattice pixels that a view covers.
class Coverage {
 public:
  Coverage(const DenseView& view, const PixelLattice& lattice)
      : words_(lattice.size() / 64 + 1) {
    for (const DenseMatch& match : view.matches)
      words_[match.pixel / 64].set(match.pixel % 64);
  }

  static size_t Overlap(const Coverage& a, const Coverage& b,
                        const Coverage& c) {
    size_t count = 0;
    for (size_t k = 0; k < a.words_.size(); ++k)
      count += (a.words_[k] & b.words_[k] & c.words_[k]).count();
    return count;
  }

 private:
  std::vector<std::bitset<64>> words_;
};

using ViewIndices = std::array<int, 3>;

// Draws distinct ordered triplets of overlapping views. The order matters,
// since the first view's board is the reference.
std::vector<ViewIndices> SampleTriplets(const std::vector<DenseView>& views,
                                        const PixelLattice& lattice,
                                        const TripletOptions& options) {
  const size_t count = views.size();
  std::vector<Coverage> coverage;
  for (const DenseView& view : views) coverage.emplace_back(view, lattice);
  std::mt19937_64 random(options.seed);
  std::set<ViewIndices> seen;
  std::vector<ViewIndices> triplets;
  for (int i = 0; count >= 3 && i < kMaxTries; ++i) {
    if (static_cast<int>(triplets.size()) == options.max_triplets) break;
    ViewIndices triplet;
    for (int& view : triplet) view = static_cast<int>(random() % count);
    ViewIndices sorted = triplet;
    std::sort(sorted.begin(), sorted.end());
    if (sorted[0] == sorted[1] || sorted[1] == sorted[2] ||
        !seen.insert(sorted).second)
      continue;
    if (Coverage::Overlap(coverage[triplet[0]], coverage[triplet[1]],
                          coverage[triplet[2]]) >= kMinOverlap)
      triplets.push_back(triplet);
  }
  return triplets;
}

template <typename T>
std::vector<T> Subsample(const std::vector<T>& all, size_t max_count) {
  const size_t count = std::min(all.size(), max_count);
  std::vector<T> some;
  for (size_t i = 0; i < count; ++i)
    some.push_back(all[i * all.size() / count]);
  return some;
}

struct Candidate {
  SolvedTriplet triplet;
  std::vector<BoardPointTriple> matches;
  double score = 0;
};

Candidate Solve(const std::vector<DenseView>& views,
                const ViewIndices& indices) {
  const std::vector<BoardPointTriple> matches = FindCommonMatches(
      views[indices[0]], views[indices[1]], views[indices[2]]);
  Candidate candidate;
  candidate.triplet.views = indices;
  candidate.triplet.num_matches = matches.size();
  candidate.matches = Subsample(matches, kMaxMatches);
  const ThreeViewsSolution solution = SolveThreeViews(candidate.matches);
  if (solution.status != ThreeViewsStatus::kSolved) return candidate;
  candidate.triplet.poses = solution.views;
  // The effect of noise, relative to the width of the overlap, is inversely
  // proportional to the conditioning.
  candidate.score = solution.conditioning * static_cast<double>(matches.size());
  return candidate;
}

}  // namespace

std::vector<SolvedTriplet> SelectTriplets(const std::vector<DenseView>& views,
                                          const PixelLattice& lattice,
                                          int count,
                                          const TripletOptions& options) {
  const std::vector<ViewIndices> sample =
      SampleTriplets(views, lattice, options);
  std::vector<Candidate> candidates(sample.size());
  ParallelFor(static_cast<int>(sample.size()), options.num_threads,
              [&](int i) { candidates[i] = Solve(views, sample[i]); });
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  if (candidates.size() > kMaxRefined) candidates.resize(kMaxRefined);
  ParallelFor(
      static_cast<int>(candidates.size()), options.num_threads, [&](int i) {
        Candidate& candidate = candidates[i];
        if (candidate.score > 0)
          candidate.triplet.fit =
              RefineThreeViews(candidate.matches, &candidate.triplet.poses);
      });
  std::vector<SolvedTriplet> solved;
  for (const Candidate& candidate : candidates)
    if (candidate.triplet.fit.converged) solved.push_back(candidate.triplet);
  std::stable_sort(solved.begin(), solved.end(),
                   [](const SolvedTriplet& a, const SolvedTriplet& b) {
                     return a.fit.center_uncertainty < b.fit.center_uncertainty;
                   });
  if (static_cast<int>(solved.size()) > count) solved.resize(count);
  return solved;
}

}  // namespace raygrid
