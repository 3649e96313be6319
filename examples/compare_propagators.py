"""How far each propagator is from the analytic solution: a lit square of 4 x 4 cells in a volume of 16^3."""

from octolux.simulator.laboratory import PROPAGATORS, Area, Simulation

square = Area((3, 6, 6), (3, 9, 9), direction=(1, 0, 0))

print("propagator       gain   error from analytic after 0, 8 and 32 steps   centre of the 8th step")
for name, propagator in PROPAGATORS.items():
    simulation = Simulation(16, propagator=name, injectors=[square], compare=["analytic"])
    simulation.run(32)
    rows = simulation.state.measures
    errors = "  ".join(f"{rows[k]['analytic_uniform_rel']:12.3f}" for k in (0, 8, 32))
    print(f"{name:15} {propagator.gain:5.2f}  {errors}   {rows[8]['step_centre_x'] - 3:15.2f} cells on")
