// Debian's Ipopt, an older and independent build, solves what the controller's CasADi solves: the same functions (as C
// code generated from them), the same instances, the same start. Both must find the same cost and the same input.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#define HAVE_CSTDDEF
#include <coin/IpIpoptApplication.hpp>
#include <coin/IpTNLP.hpp>

extern "C" {
#include "problem.h"
}

namespace {

using Ipopt::Index;
using Ipopt::Number;
using Numbers = std::vector<double>;

/// One instance: parameters, bounds, start, and what Python found.
struct Instance {
  Numbers p, lower, upper, g_lower, g_upper, start, cost, input;
};

struct Instances {
  std::vector<Instance> all;
  std::vector<std::size_t> input_columns;  // where the first input stands in x
};

Instances readInstances(const std::string& path) {
  std::ifstream file(path);
  std::size_t count = 0, n = 0, parameters = 0, m = 0, inputs = 0;
  file >> count >> n >> parameters >> m >> inputs;
  Instances result;
  result.input_columns.resize(inputs);
  for (std::size_t& column : result.input_columns) file >> column;
  const auto read = [&file](Numbers& values, std::size_t size) {
    values.resize(size);
    for (double& value : values) file >> value;
  };
  for (std::size_t i = 0; i < count && file; ++i) {
    Instance one;
    read(one.p, parameters);
    read(one.lower, n);
    read(one.upper, n);
    read(one.g_lower, m);
    read(one.g_upper, m);
    read(one.start, n);
    read(one.cost, 1);
    read(one.input, inputs);
    result.all.push_back(one);
  }
  EXPECT_TRUE(file) << path << " cannot be read to its end";
  return result;
}

/// A function that CasADi wrote: its work space and the rows and columns of its first output's nonzeros.
class Generated {
 public:
  using Call = int (*)(const double**, double**, casadi_int*, double*, int);
  using Work = int (*)(casadi_int*, casadi_int*, casadi_int*, casadi_int*);
  using Sparsity = const casadi_int* (*)(casadi_int);

  Generated(Call call, Work work, Sparsity sparsity) : call_(call) {
    casadi_int arguments = 0, results = 0, integers = 0, doubles = 0;
    work(&arguments, &results, &integers, &doubles);
    arguments_.resize(static_cast<std::size_t>(arguments));
    results_.resize(static_cast<std::size_t>(results));
    integers_.resize(static_cast<std::size_t>(integers));
    doubles_.resize(static_cast<std::size_t>(doubles));
    const casadi_int* pattern = sparsity(0);  // rows, columns, column starts, row of each nonzero
    const casadi_int columns = pattern[1];
    const casadi_int *starts = pattern + 2, *rows = starts + columns + 1;
    for (casadi_int column = 0; column < columns; ++column) {
      for (casadi_int k = starts[column]; k < starts[column + 1]; ++k) {
        this->rows.push_back(static_cast<Index>(rows[k]));
        this->columns.push_back(static_cast<Index>(column));
      }
    }
  }

  void operator()(const std::vector<const double*>& arguments, double* result) {
    std::copy(arguments.begin(), arguments.end(), arguments_.begin());
    results_[0] = result;
    call_(arguments_.data(), results_.data(), integers_.data(), doubles_.data(), 0);
  }

  std::vector<Index> rows, columns;

 private:
  Call call_;
  std::vector<const double*> arguments_;
  std::vector<double*> results_;
  std::vector<casadi_int> integers_;
  Numbers doubles_;
};

#define GENERATED(name) Generated(name, name##_work, name##_sparsity_out)

/// The problem as Ipopt takes it.
class DockingNlp : public Ipopt::TNLP {
 public:
  explicit DockingNlp(const Instance& instance) : instance_(instance) {}

  bool get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian, IndexStyleEnum& style) override {
    n = static_cast<Index>(instance_.start.size());
    m = static_cast<Index>(instance_.g_lower.size());
    jacobian = static_cast<Index>(jacobian_.rows.size());
    hessian = static_cast<Index>(hessian_.rows.size());
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index, Number* lower, Number* upper, Index, Number* g_lower, Number* g_upper) override {
    std::copy(instance_.lower.begin(), instance_.lower.end(), lower);
    std::copy(instance_.upper.begin(), instance_.upper.end(), upper);
    std::copy(instance_.g_lower.begin(), instance_.g_lower.end(), g_lower);
    std::copy(instance_.g_upper.begin(), instance_.g_upper.end(), g_upper);
    return true;
  }

  bool get_starting_point(Index, bool, Number* x, bool, Number*, Number*, Index, bool, Number*) override {
    std::copy(instance_.start.begin(), instance_.start.end(), x);
    return true;
  }

  bool eval_f(Index, const Number* x, bool, Number& value) override {
    objective_({x, instance_.p.data()}, &value);
    return std::isfinite(value);
  }

  bool eval_grad_f(Index, const Number* x, bool, Number* values) override {
    gradient_({x, instance_.p.data()}, values);
    return true;
  }

  bool eval_g(Index, const Number* x, bool, Index, Number* values) override {
    constraints_({x, instance_.p.data()}, values);
    return true;
  }

  bool eval_jac_g(Index, const Number* x, bool, Index, Index, Index* rows, Index* columns, Number* values) override {
    if (values == nullptr) return copyPattern(jacobian_, rows, columns);
    jacobian_({x, instance_.p.data()}, values);
    return true;
  }

  bool eval_h(Index, const Number* x, bool, Number sigma, Index, const Number* lambda, bool, Index, Index* rows,
              Index* columns, Number* values) override {
    if (values == nullptr) return copyPattern(hessian_, rows, columns);
    hessian_({x, instance_.p.data(), &sigma, lambda}, values);
    return true;
  }

  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* x, const Number*, const Number*, Index,
                         const Number*, const Number*, Number cost, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    x_.assign(x, x + n);
    cost_ = cost;
  }

  const Numbers& x() const { return x_; }
  double cost() const { return cost_; }

 private:
  static bool copyPattern(const Generated& function, Index* rows, Index* columns) {
    std::copy(function.rows.begin(), function.rows.end(), rows);
    std::copy(function.columns.begin(), function.columns.end(), columns);
    return true;
  }

  const Instance& instance_;
  Generated objective_ = GENERATED(objective), gradient_ = GENERATED(gradient), constraints_ = GENERATED(constraints),
            jacobian_ = GENERATED(jacobian), hessian_ = GENERATED(hessian);
  Numbers x_;
  double cost_ = 0.0;
};

/// Largest differences of cost and first input between both solvers; NaN when Ipopt did not converge.
std::pair<double, double> differences(const Instance& instance, const std::vector<std::size_t>& input_columns) {
  Ipopt::SmartPtr<Ipopt::IpoptApplication> ipopt = IpoptApplicationFactory();
  ipopt->Options()->SetNumericValue("tol", 1e-10);
  ipopt->Options()->SetIntegerValue("max_iter", 1000);
  ipopt->Options()->SetIntegerValue("print_level", 0);
  ipopt->Options()->SetStringValue("sb", "yes");
  EXPECT_EQ(ipopt->Initialize(), Ipopt::Solve_Succeeded);
  auto* nlp = new DockingNlp(instance);
  const Ipopt::SmartPtr<Ipopt::TNLP> owner = nlp;
  if (ipopt->OptimizeTNLP(owner) != Ipopt::Solve_Succeeded) return {NAN, NAN};
  double worst = 0.0;
  for (std::size_t i = 0; i < input_columns.size(); ++i) {
    worst = std::max(worst, std::abs(nlp->x()[input_columns[i]] - instance.input[i]));
  }
  return {std::abs(nlp->cost() - instance.cost[0]), worst};
}

TEST(IpoptJudge, agreesOnEveryInstance) {
  const Instances instances = readInstances(SEATER_JUDGE_INSTANCES);
  ASSERT_EQ(instances.all.size(), 100U);
  double worst_cost = 0.0, worst_input = 0.0;
  for (std::size_t i = 0; i < instances.all.size(); ++i) {
    const auto [cost, input] = differences(instances.all[i], instances.input_columns);
    EXPECT_LE(cost, 1e-6) << "instance " << i;
    EXPECT_LE(input, 1e-6) << "instance " << i;
    worst_cost = std::max(worst_cost, cost);
    worst_input = std::max(worst_input, input);
  }
  std::printf("largest difference of 100 instances: cost %.2e, first input %.2e\n", worst_cost, worst_input);
}

/// The comparison sees a difference: another initial speed is another solution.
TEST(IpoptJudge, disagreesOnAnotherInstance) {
  Instances instances = readInstances(SEATER_JUDGE_INSTANCES);
  Instance& one = instances.all.front();
  one.lower[3] += 0.01;
  one.upper[3] += 0.01;
  EXPECT_GT(differences(one, instances.input_columns).first, 1e-5);
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
