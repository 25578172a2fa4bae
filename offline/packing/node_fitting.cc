#include "packing/node_fitting.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>

#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

constexpr int kFitCell = SourceMap::kCellSize;

// Returns the sums over a cell with a source at every pixel. They are sums of
// integers, and therefore exact.
CellSums::Sources SumInteriorCell(const SourceMap& map, int column, int row) {
  CellSums::Sources sums;
  for (int axis = 0; axis < 2; ++axis) {
    double plain[kFitCell] = {}, by_y[kFitCell] = {};  // by column of the cell
    for (int y = 0; y < kFitCell; ++y) {
      const int32_t* const units =
          &map.sources[axis][map.Index(column * kFitCell, row * kFitCell + y)];
      for (int x = 0; x < kFitCell; ++x) {
        plain[x] += units[x];
        by_y[x] += static_cast<double>(y) * units[x];
      }
    }
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (int x = 0; x < kFitCell; ++x)
      sum += Eigen::Vector4d(plain[x], x * plain[x], by_y[x], x * by_y[x]);
    sums.col(axis) = sum / SourceMap::kUnitsPerPx;
  }
  return sums;
}

struct PartialSums {
  CellSums::Sources sources = CellSums::Sources::Zero();
  CellSums::Products products = CellSums::Products::Zero();
};

PartialSums SumCell(const SourceMap& map, int column, int row) {
  PartialSums sums;
  for (int y = 0; y < kFitCell; ++y) {
    for (int x = 0; x < kFitCell; ++x) {
      if (!map.IsKnown(column * kFitCell + x, row * kFitCell + y)) continue;
      const Eigen::Vector4d powers(1, x, y, x * y);
      sums.products += powers * powers.transpose();
      sums.sources +=
          powers *
          map.At(column * kFitCell + x, row * kFitCell + y).transpose();
    }
  }
  return sums;
}

CellSums::Products MakeInteriorProducts() {
  CellSums::Products products = CellSums::Products::Zero();
  for (int y = 0; y < kFitCell; ++y) {
    for (int x = 0; x < kFitCell; ++x) {
      const Eigen::Vector4d powers(1, x, y, x * y);
      products += powers * powers.transpose();
    }
  }
  return products;
}

// The weights of a block's nodes at one of its pixels: of the four vertices,
// followed, with bends, by the upper, lower, left and right edge. A bend's
// weight is maximal at its edge's midpoint, and zero at its ends and on the
// opposite edge; it is linear between tile corners.
template <int kNodes>
class BlockBasis {
 public:
  using Nodes = std::array<int, kNodes>;
  // The coefficients of 1, x, y and x y for a pixel (x, y) of a cell.
  using EvaluateBasis = Eigen::Matrix<double, kNodes, 4>;

  explicit BlockBasis(const Blocks& blocks)
      : blocks_(blocks), cells_(blocks.size() / kFitCell) {
    for (int row = 0; row < cells_; ++row)
      for (int column = 0; column < cells_; ++column)
        factors_.push_back(MakeFactors(column * kFitCell, row * kFitCell));
  }

  // The coefficients for the cell in a column and row of its block, and for all
  // cells.
  const EvaluateBasis& Of(int column, int row) const {
    return factors_[row * cells_ + column];
  }
  const std::vector<EvaluateBasis>& factors() const { return factors_; }
  int num_cells() const { return cells_; }  // along an edge

  Nodes GetBlockNodes(int i, int j) const {
    Nodes nodes;
    for (int k = 0; k < 4; ++k)
      nodes[k] = blocks_.VertexIndex(i + k % 2, j + k / 2);
    if constexpr (kNodes == 8) {
      for (int k = 0; k < 2; ++k) {
        nodes[4 + k] = blocks_.LeftSagittaIndex(i + 1, j + k);
        nodes[6 + k] = blocks_.UpperSagittaIndex(i + k, j + 1);
      }
    }
    return nodes;
  }

 private:
  // A linear function: its value at a cell's first pixel, and its increment per
  // pixel.
  struct Line {
    double value, step;
  };

  Line Curve(int x) const {
    const int n = blocks_.size(), part = 1 << blocks_.layout.part_log2;
    const auto curve = [n](int at) { return 4.0 * at * (n - at) / (n * n); };
    const int first = x / part * part;
    const double step = (curve(first + part) - curve(first)) / part;
    return {curve(first) + (x - first) * step, step};
  }

  // Returns the coefficients for the cell at pixel (x, y) of a block.
  EvaluateBasis MakeFactors(int x, int y) const {
    const double unit = 1.0 / blocks_.size();
    const Line right = {x * unit, unit}, left = {1 - x * unit, -unit};
    const Line down = {y * unit, unit}, up = {1 - y * unit, -unit};
    EvaluateBasis factors;
    const auto set = [&factors](int node, const Line& across,
                                const Line& along) {
      factors.row(node) << across.value * along.value,
          across.step * along.value, across.value * along.step,
          across.step * along.step;
    };
    set(0, left, up);
    set(1, right, up);
    set(2, left, down);
    set(3, right, down);
    if constexpr (kNodes == 8) {
      set(4, Curve(x), up);
      set(5, Curve(x), down);
      set(6, left, Curve(y));
      set(7, right, Curve(y));
    }
    return factors;
  }

  const Blocks& blocks_;
  int cells_;
  std::vector<EvaluateBasis> factors_;
};

// The least-squares problem for the nodes of used blocks. Second differences of
// nodes of the same kind are regularized where pixels do not determine them.
template <int kNodes>
class NodeEquations {
 public:
  NodeEquations(const CellSums& sums, const Blocks& blocks)
      : right_(NodePositions::Zero(blocks.num_nodes(), 2)),
        diagonal_(Eigen::ArrayXd::Constant(blocks.num_nodes(), kHold)) {
    const BlockBasis<kNodes> basis(blocks);
    normals_ = {Normal::Zero()};
    for (const EvaluateBasis& factors : basis.factors())
      normals_[kWhole] += Product(factors, sums.interior_products());
    for (int j = 0; j < blocks.rows; ++j)
      for (int i = 0; i < blocks.columns; ++i)
        if (blocks.IsUsed(i, j)) AddBlock(sums, basis, i, j);
    AddSmoothness(blocks);
  }

  // Solves by conjugate gradients, for both coordinates at once, until no
  // single node could reduce the sum of squared errors by more than
  // kTolerancePx squared.
  NodePositions Solve() const {
    NodePositions nodes = Start(), product(nodes.rows(), 2);
    Multiply(nodes, &product);
    NodePositions rest = right_ - product;
    NodePositions scaled = rest.array().colwise() / diagonal_;
    NodePositions direction = scaled;
    PerCoordinate square = Dot(rest, scaled);
    for (int k = 0; k < kMaxIterations; ++k) {
      if (!((rest.array() * scaled.array()).maxCoeff() >
            kTolerancePx * kTolerancePx))
        break;
      Multiply(direction, &product);
      const PerCoordinate length = square / Dot(direction, product).max(kTiny);
      nodes.array() += direction.array().rowwise() * length;
      rest.array() -= product.array().rowwise() * length;
      scaled = rest.array().colwise() / diagonal_;
      const PerCoordinate next_square = Dot(rest, scaled);
      const PerCoordinate ratio = next_square / square.max(kTiny);
      direction = scaled.array() + direction.array().rowwise() * ratio;
      square = next_square;
    }
    return nodes;
  }

 private:
  static constexpr double kSmoothness = 1e-3, kHold = 1e-9, kTiny = 1e-300;
  static constexpr double kTolerancePx = 1e-3;
  static constexpr int kMaxIterations = 500;
  using EvaluateBasis = typename BlockBasis<kNodes>::EvaluateBasis;
  using Normal = Eigen::Matrix<double, kNodes, kNodes>;
  using BlockPositions = Eigen::Matrix<double, kNodes, 2, Eigen::RowMajor>;
  using PerCoordinate = Eigen::Array<double, 1, 2>;
  struct Block {
    int column, row;
    typename BlockBasis<kNodes>::Nodes nodes;
    BlockPositions right;
    int normal;  // index
  };
  static constexpr int kWhole = 0;  // normal matrix shared by whole blocks
  struct SecondDifference {
    int center, step;
  };
  // Origin, step to the next column, step to the next row of blocks.
  using Affine = Eigen::Matrix<double, 3, 2>;

  static Normal Product(const EvaluateBasis& factors,
                        const CellSums::Products& products) {
    return factors * products * factors.transpose();
  }
  static PerCoordinate Dot(const NodePositions& a, const NodePositions& b) {
    return (a.array() * b.array()).colwise().sum();
  }

  void AddBlock(const CellSums& sums, const BlockBasis<kNodes>& basis, int i,
                int j) {
    Block block = {i, j, basis.GetBlockNodes(i, j), BlockPositions::Zero(),
                   kWhole};
    const int cells = basis.num_cells();
    // The last block may extend beyond the last cell.
    const int columns = std::min(cells, sums.columns() - i * cells);
    const int rows = std::min(cells, sums.rows() - j * cells);
    bool is_whole = columns == cells && rows == cells;
    Normal normal = Normal::Zero();
    for (int row = j * cells; row < j * cells + rows; ++row) {
      for (int column = i * cells; column < i * cells + columns; ++column) {
        const EvaluateBasis& factors = basis.Of(column % cells, row % cells);
        block.right += factors.lazyProduct(sums.sources(column, row));
        is_whole &= sums.IsWhole(column, row);
      }
    }
    for (int row = j * cells; row < j * cells + rows && !is_whole; ++row)
      for (int column = i * cells; column < i * cells + columns; ++column)
        normal += Product(basis.Of(column % cells, row % cells),
                          sums.products(column, row));
    if (!is_whole) {
      block.normal = static_cast<int>(normals_.size());
      normals_.push_back(normal);
    }
    for (int k = 0; k < kNodes; ++k) {
      right_.row(block.nodes[k]) += block.right.row(k);
      diagonal_[block.nodes[k]] += normals_[block.normal](k, k);
    }
    blocks_.push_back(block);
  }

  void AddSmoothness(const Blocks& blocks) {
    const std::vector<bool> needed = FindRequiredNodes(blocks);
    const auto add = [&](int k, int step) {
      if (!needed[k - step] || !needed[k] || !needed[k + step]) return;
      differences_.push_back({k, step});
      diagonal_[k - step] += kSmoothness;
      diagonal_[k] += 4 * kSmoothness;
      diagonal_[k + step] += kSmoothness;
    };
    const int down = blocks.columns + 1;
    for (int k = 0; k < blocks.num_nodes(); ++k) {
      const int i = k % down, j = k % blocks.num_vertices() / down;
      if (i > 0 && i < blocks.columns) add(k, 1);
      if (j > 0 && j < blocks.rows) add(k, down);
    }
  }

  // Initializes vertices by affine maps fitted to the pixels of their blocks,
  // without bends.
  NodePositions Start() const {
    // Evaluates an affine map, given relative to a block, at the block's nodes.
    Eigen::Matrix<double, kNodes, 3> at_nodes =
        Eigen::Matrix<double, kNodes, 3>::Zero();
    for (int k = 0; k < 4; ++k) at_nodes.row(k) << 1, k % 2, k / 2;
    // Converts an affine map relative to the first block to one relative to
    // this block.
    const auto from_block = [](const Block& block) {
      Eigen::Matrix3d frame = Eigen::Matrix3d::Identity();
      frame.row(0) << 1, block.column, block.row;
      return frame;
    };
    Eigen::Matrix3d normal = kHold * Eigen::Matrix3d::Identity();
    Affine right = Affine::Zero();
    for (const Block& block : blocks_) {
      const Eigen::Matrix<double, kNodes, 3> nodes =
          at_nodes * from_block(block);
      normal += nodes.transpose() * normals_[block.normal] * nodes;
      right += nodes.transpose() * block.right;
    }
    const Affine overall = normal.ldlt().solve(right);

    NodePositions start = NodePositions::Zero(right_.rows(), 2);
    Eigen::ArrayXd weights = Eigen::ArrayXd::Constant(right_.rows(), kTiny);
    for (const Block& block : blocks_) {
      const Affine expected = from_block(block) * overall;
      normal = at_nodes.transpose() * normals_[block.normal] * at_nodes;
      right = at_nodes.transpose() * block.right - normal * expected;
      const double num_pixels = normal(0, 0);
      // Regularized, since a few pixels do not determine the steps.
      normal.diagonal() += Eigen::Vector3d(kHold, 1e-2, 1e-2);
      const Affine found = expected + normal.ldlt().solve(right);
      for (int k = 0; k < 4; ++k) {
        start.row(block.nodes[k]) += num_pixels * at_nodes.row(k) * found;
        weights[block.nodes[k]] += num_pixels;
      }
    }
    return start.array().colwise() / weights;
  }

  void Multiply(const NodePositions& nodes, NodePositions* product) const {
    *product = kHold * nodes;
    for (const Block& block : blocks_) {
      BlockPositions own;
      for (int k = 0; k < kNodes; ++k) own.row(k) = nodes.row(block.nodes[k]);
      const BlockPositions result = normals_[block.normal].lazyProduct(own);
      for (int k = 0; k < kNodes; ++k)
        product->row(block.nodes[k]) += result.row(k);
    }
    for (const auto& [k, step] : differences_) {
      const Eigen::RowVector2d weighted =
          kSmoothness *
          (nodes.row(k - step) - 2 * nodes.row(k) + nodes.row(k + step));
      product->row(k - step) += weighted;
      product->row(k) -= 2 * weighted;
      product->row(k + step) += weighted;
    }
  }

  std::vector<Block> blocks_;
  std::vector<Normal> normals_;
  std::vector<SecondDifference> differences_;
  NodePositions right_;
  Eigen::ArrayXd diagonal_;
};

NodePositions FitLeastSquares(const CellSums& sums, const Blocks& blocks) {
  if (blocks.layout.HasCurvedEdges())
    return NodeEquations<8>(sums, blocks).Solve();
  return NodeEquations<4>(sums, blocks).Solve();
}

// Shifts vertices to minimize the maximum error. Where second derivatives are
// constant, the error of interpolation along each direction is a parabola with
// some height. Least squares shift its ends, the vertices, by 2/3 of the height
// to one side of the exact position; the maximum error is minimal for half of
// the height, 3/4 of that shift. This also holds for the two halves of an edge
// between its ends and its midpoint. Vertices outside the image are shifted
// like the last one inside.
NodePositions Balance(const SourceMap& map, const Blocks& blocks,
                      const NodePositions& fitted) {
  NodePositions moves = NodePositions::Zero(fitted.rows(), 2);
  const std::vector<bool> needed = FindRequiredNodes(blocks);
  // The correction that an output pixel requires; nullopt without a source.
  const auto lack = [&](int x, int y, const Eigen::RowVector2d& position) {
    if (x >= map.width || y >= map.height || !map.IsKnown(x, y))
      return Eigen::RowVector2d(0, 0);
    return Eigen::RowVector2d(0.25 * (map.At(x, y).transpose() - position));
  };
  for (int j = 0; j <= blocks.rows; ++j) {
    for (int i = 0; i <= blocks.columns; ++i) {
      const int in_i = std::min(i, blocks.columns - 1);
      const int in_j = std::min(j, blocks.rows - 1);
      const int vertex = blocks.VertexIndex(in_i, in_j);
      if (needed[vertex])
        moves.row(blocks.VertexIndex(i, j)) =
            lack(in_i << blocks.size_log2(), in_j << blocks.size_log2(),
                 fitted.row(vertex));
    }
  }
  // The edge from vertex a to b, whose midpoint is output pixel (x, y).
  const auto balance = [&](int a, int b, int bend, int x, int y) {
    const Eigen::RowVector2d line = (fitted.row(a) + fitted.row(b)) / 2;
    const Eigen::RowVector2d moved = (moves.row(a) + moves.row(b)) / 2;
    moves.row(bend) = lack(x, y, line + fitted.row(bend)) - moved;
  };
  for (int j = 0; j <= blocks.rows && blocks.layout.HasCurvedEdges(); ++j) {
    for (int i = 0; i <= blocks.columns; ++i) {
      const int x = i << blocks.size_log2(), y = j << blocks.size_log2();
      const int half = blocks.size() / 2, k = blocks.VertexIndex(i, j);
      if (i > 0 && needed[blocks.LeftSagittaIndex(i, j)])
        balance(k - 1, k, blocks.LeftSagittaIndex(i, j), x - half, y);
      if (j > 0 && needed[blocks.UpperSagittaIndex(i, j)])
        balance(blocks.VertexIndex(i, j - 1), k, blocks.UpperSagittaIndex(i, j),
                x, y - half);
    }
  }
  return fitted + moves;
}

}  // namespace

CellSums::CellSums(const SourceMap& map, int num_threads)
    : columns_(map.columns),
      rows_(map.rows),
      sources_(map.cells.size()),
      products_({MakeInteriorProducts()}),
      which_(map.cells.size(), kWhole) {
  std::vector<std::vector<Products>> partial(map.rows);
  ParallelFor(map.rows, num_threads, [&](int row) {
    for (int column = 0; column < map.columns; ++column) {
      const int k = row * columns_ + column;
      if (map.cells[k] == SourceMap::Cell::kWhole) {
        sources_[k] = SumInteriorCell(map, column, row);
        continue;
      }
      const PartialSums sums = SumCell(map, column, row);
      sources_[k] = sums.sources;
      partial[row].push_back(sums.products);
    }
  });
  for (int row = 0; row < map.rows; ++row) {
    int next = static_cast<int>(products_.size());
    for (int column = 0; column < map.columns; ++column)
      if (map.cell(column, row) != SourceMap::Cell::kWhole)
        which_[row * columns_ + column] = next++;
    products_.insert(products_.end(), partial[row].begin(), partial[row].end());
  }
}

NodePositions FitNodes(const SourceMap& map, const CellSums& sums,
                       const Blocks& blocks) {
  return Balance(map, blocks, FitLeastSquares(sums, blocks));
}

}  // namespace raygrid
