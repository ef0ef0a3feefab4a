// Two free rigid bodies side by side: every state is the caller's, so they do not meet.
#include "free_rigid_body.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <vector>

class Top {
public:
  Top(double I1, double I2, double I3, double h) {
    free_rigid_body_params p;
    free_rigid_body_defaults(&p);
    p.I1 = I1, p.I2 = I2, p.I3 = I3;
    check(free_rigid_body_model_init(&model, &p));
    memory.resize(free_rigid_body_memsize(&model) / sizeof(smg_real) + 1);
    const smg_real w[3] = {std::cos(1.1), 0, std::sin(1.1)};
    check(free_rigid_body_init(&s, &model, memory.data(), w, 0.0, h));
  }
  Top(const Top &) = delete; // the state points into its own memory
  Top &operator=(const Top &) = delete;

  void step() { check(free_rigid_body_step(&s)); }
  const smg_real *w() const { return s.w; }
  double time() const { return free_rigid_body_time(&s); }

private:
  static void check(smg_status status) {
    if (status != SMG_OK) throw std::runtime_error(smg_message(status));
  }
  free_rigid_body_model model;
  free_rigid_body_state s;
  std::vector<smg_real> memory;
};

int main() {
  Top paper(1, 2, 4, 0.0078125), figure(1, 4.0 / 3, 2, 0.0078125);
  for (int step = 0; step < 1280; step++) {
    paper.step();
    figure.step();
  }
  for (const Top *top : {&paper, &figure})
    std::printf("w(%g) = %.5f %.5f %.5f\n", top->time(), top->w()[0], top->w()[1], top->w()[2]);
}
