// Debian's Ipopt as an independent judge of CasADi's: the controller's problem from the generated C code, the same
// instances from the same points (make_instances.py), another build of the solver, its own derivatives' plumbing.

#include <gtest/gtest.h>
#include <link.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#define HAVE_CSTDDEF  // Debian's 3.11.9 headers ask for it
#include <coin/IpIpoptApplication.hpp>
#include <coin/IpTNLP.hpp>
#undef HAVE_CSTDDEF

#include "judge_problem.h"

namespace {

using Ipopt::Index;
using Ipopt::Number;
using Vector = std::vector<double>;

constexpr double kAgreement = 1e-6;  // of cost and of first input [m/s^2, rad/s^2]
constexpr std::size_t kInstances = 100;
constexpr double kInfinity = 2e19;  // what Ipopt takes for unbounded

struct Instance {
  Vector p, lbx, ubx, lbg, ubg, x0;
  double cost = 0.0;
  std::array<double, 2> input{};
};

struct Suite {
  std::vector<std::pair<std::string, std::string>> options;
  std::size_t nx = 0, np = 0, ng = 0, first_input = 0;
  std::vector<Instance> instances;
};

Vector readLine(std::istream& in, std::size_t size) {
  std::string line;
  std::getline(in, line);
  std::istringstream words(line);
  Vector values;
  for (std::string word; words >> word;) {  // a stream would not read "inf"
    values.push_back(std::clamp(std::stod(word), -kInfinity, kInfinity));
  }
  if (values.size() != size) {
    throw std::runtime_error("instance file: expected " + std::to_string(size) + " numbers, got " +
                             std::to_string(values.size()));
  }
  return values;
}

Suite readSuite(const std::string& path) {
  std::ifstream in(path);
  if (!in) {
    throw std::runtime_error("cannot read " + path);
  }
  Suite suite;
  std::size_t count = 0;
  std::string word, name, value;
  while (in >> word && word == "option") {
    in >> name >> value;
    suite.options.emplace_back(name, value);
  }
  in >> suite.nx >> suite.np >> suite.ng >> suite.first_input >> count;
  std::getline(in, word);
  for (std::size_t i = 0; i < count; ++i) {
    Instance one;
    one.p = readLine(in, suite.np);
    one.lbx = readLine(in, suite.nx);
    one.ubx = readLine(in, suite.nx);
    one.lbg = readLine(in, suite.ng);
    one.ubg = readLine(in, suite.ng);
    one.x0 = readLine(in, suite.nx);
    const Vector solution = readLine(in, 3);
    one.cost = solution[0];
    one.input = {solution[1], solution[2]};
    suite.instances.push_back(std::move(one));
  }
  return suite;
}

// One of the generated functions with its work space; one output.
class Generated {
 public:
  using Evaluate = int (*)(const casadi_real**, casadi_real**, casadi_int*, casadi_real*, int);
  using Work = int (*)(casadi_int*, casadi_int*, casadi_int*, casadi_int*);
  using Sparsity = const casadi_int* (*)(casadi_int);

  Generated(Evaluate evaluate, Work work, Sparsity sparsity) : evaluate_(evaluate), pattern_(sparsity(0)) {
    casadi_int arguments = 0, results = 0, integers = 0, reals = 0;
    work(&arguments, &results, &integers, &reals);
    arguments_.resize(static_cast<std::size_t>(arguments));
    results_.resize(static_cast<std::size_t>(results));
    integers_.resize(static_cast<std::size_t>(integers));
    reals_.resize(static_cast<std::size_t>(reals));
  }

  bool operator()(const std::vector<const double*>& inputs, double* output) {
    std::copy(inputs.begin(), inputs.end(), arguments_.begin());
    results_[0] = output;
    return evaluate_(arguments_.data(), results_.data(), integers_.data(), reals_.data(), 0) == 0;
  }

  // Compressed columns: rows, columns, (columns + 1) offsets, the row of each nonzero.
  Index nonzeros() const { return static_cast<Index>(pattern_[2 + pattern_[1]]); }

  void triplets(Index* rows, Index* columns) const {
    const casadi_int count = pattern_[1];
    const casadi_int* offsets = pattern_ + 2;
    for (casadi_int column = 0; column < count; ++column) {
      for (casadi_int k = offsets[column]; k < offsets[column + 1]; ++k) {
        rows[k] = static_cast<Index>(offsets[count + 1 + k]);
        columns[k] = static_cast<Index>(column);
      }
    }
  }

 private:
  Evaluate evaluate_;
  const casadi_int* pattern_;
  std::vector<const casadi_real*> arguments_;
  std::vector<casadi_real*> results_;
  std::vector<casadi_int> integers_;
  Vector reals_;
};

class JudgedProblem : public Ipopt::TNLP {
 public:
  explicit JudgedProblem(Instance instance) : data_(std::move(instance)) {}

  double cost() const { return cost_; }
  const Vector& solution() const { return x_; }

  bool get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian, IndexStyleEnum& style) override {
    n = static_cast<Index>(data_.x0.size());
    m = static_cast<Index>(data_.lbg.size());
    jacobian = jac_g_.nonzeros();
    hessian = hess_l_.nonzeros();
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index, Number* lbx, Number* ubx, Index, Number* lbg, Number* ubg) override {
    std::copy(data_.lbx.begin(), data_.lbx.end(), lbx);
    std::copy(data_.ubx.begin(), data_.ubx.end(), ubx);
    std::copy(data_.lbg.begin(), data_.lbg.end(), lbg);
    std::copy(data_.ubg.begin(), data_.ubg.end(), ubg);
    return true;
  }

  bool get_starting_point(Index, bool, Number* x, bool, Number*, Number*, Index, bool, Number*) override {
    std::copy(data_.x0.begin(), data_.x0.end(), x);
    return true;
  }

  bool eval_f(Index, const Number* x, bool, Number& value) override { return f_({x, data_.p.data()}, &value); }
  bool eval_grad_f(Index, const Number* x, bool, Number* values) override {
    return grad_f_({x, data_.p.data()}, values);
  }
  bool eval_g(Index, const Number* x, bool, Index, Number* values) override { return g_({x, data_.p.data()}, values); }

  bool eval_jac_g(Index, const Number* x, bool, Index, Index, Index* rows, Index* columns, Number* values) override {
    if (values == nullptr) {
      jac_g_.triplets(rows, columns);
      return true;
    }
    return jac_g_({x, data_.p.data()}, values);
  }

  bool eval_h(Index, const Number* x, bool, Number factor, Index, const Number* lambda, bool, Index, Index* rows,
              Index* columns, Number* values) override {
    if (values == nullptr) {
      hess_l_.triplets(rows, columns);
      return true;
    }
    return hess_l_({x, data_.p.data(), &factor, lambda}, values);
  }

  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* x, const Number*, const Number*, Index,
                         const Number*, const Number*, Number cost, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    x_.assign(x, x + n);
    cost_ = cost;
  }

 private:
  Instance data_;
  Generated f_{judge_f, judge_f_work, judge_f_sparsity_out};
  Generated grad_f_{judge_grad_f, judge_grad_f_work, judge_grad_f_sparsity_out};
  Generated g_{judge_g, judge_g_work, judge_g_sparsity_out};
  Generated jac_g_{judge_jac_g, judge_jac_g_work, judge_jac_g_sparsity_out};
  Generated hess_l_{judge_hess_l, judge_hess_l_work, judge_hess_l_sparsity_out};
  Vector x_;
  double cost_ = std::numeric_limits<double>::quiet_NaN();
};

void setOption(Ipopt::OptionsList& list, const std::string& name, const std::string& value) {
  char* end = nullptr;
  const double number = std::strtod(value.c_str(), &end);
  const bool numeric = *end == '\0';
  const bool set = numeric ? list.SetNumericValue(name, number) || list.SetIntegerValue(name, static_cast<int>(number))
                           : list.SetStringValue(name, value);
  if (!set) {
    throw std::runtime_error("Ipopt refuses the option " + name + " " + value);
  }
}

struct Difference {
  double cost, input;
};

// How far Debian's solution is from the one in the file.
Difference judge(const Suite& suite, const Instance& instance) {
  Ipopt::SmartPtr<JudgedProblem> problem = new JudgedProblem(instance);
  Ipopt::SmartPtr<Ipopt::IpoptApplication> solver = new Ipopt::IpoptApplication(false);
  for (const auto& [name, value] : suite.options) {
    setOption(*solver->Options(), name, value);
  }
  EXPECT_EQ(solver->Initialize(), Ipopt::Solve_Succeeded);
  EXPECT_EQ(solver->OptimizeTNLP(Ipopt::GetRawPtr(problem)), Ipopt::Solve_Succeeded);
  if (problem->solution().size() != suite.nx) {
    return {kInfinity, kInfinity};
  }
  Difference result{std::abs(problem->cost() - instance.cost), 0.0};
  for (std::size_t i = 0; i < 2; ++i) {
    result.input = std::max(result.input, std::abs(problem->solution()[suite.first_input + i] - instance.input[i]));
  }
  return result;
}

const Suite& suite() {
  static const Suite kSuite = readSuite(SEATER_JUDGE_INSTANCES);
  return kSuite;
}

TEST(IpoptJudge, AgreesWithThePythonSolution) {
  ASSERT_EQ(suite().instances.size(), kInstances);
  Difference largest{0.0, 0.0};
  const std::size_t step = std::getenv("SEATER_EXTENSIVE") != nullptr ? 1 : 4;  // all with `./seater test --all`
  for (std::size_t i = 0; i < kInstances; i += step) {
    SCOPED_TRACE("instance " + std::to_string(i));
    const Difference difference = judge(suite(), suite().instances[i]);
    EXPECT_LE(difference.cost, kAgreement);
    EXPECT_LE(difference.input, kAgreement);
    largest = {std::max(largest.cost, difference.cost), std::max(largest.input, difference.input)};
  }
  std::cout << "largest difference over " << kInstances / step << " instances: cost " << largest.cost << ", input "
            << largest.input << std::endl;
}

TEST(IpoptJudge, SeesAMovedBound) {
  Instance moved = suite().instances.at(0);
  const std::size_t where = suite().first_input;
  moved.ubx[where] = moved.input[0] - 0.05;
  moved.lbx[where] = std::min(moved.lbx[where], moved.ubx[where] - 0.1);
  const Difference difference = judge(suite(), moved);
  EXPECT_GT(difference.cost, kAgreement);
  EXPECT_GT(difference.input, kAgreement);
}

TEST(IpoptJudge, IsNotTheSolverThatItJudges) {
  std::vector<std::string> loaded;
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* names) {
        static_cast<std::vector<std::string>*>(names)->emplace_back(info->dlpi_name);
        return 0;
      },
      &loaded);
  std::size_t ipopts = 0;
  for (const std::string& name : loaded) {
    EXPECT_EQ(name.find("casadi"), std::string::npos) << name;
    ipopts += name.find("libipopt") != std::string::npos ? 1 : 0;
  }
  EXPECT_EQ(ipopts, 1U);
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
