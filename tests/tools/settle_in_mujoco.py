"""Prints as JSON the masses and inertia of a model in MuJoCo, and how it moves within a second.

Runs in an environment that has ``mujoco``: settle_in_mujoco.py FILE
"""

import json
import sys

import mujoco
import numpy as np

model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
start = data.xipos.copy()
depth = max((-contact.dist for contact in data.contact), default=0.0)
fastest = 0.0
while data.time < 1.0:
    mujoco.mj_step(model, data)
    # Six numbers of a free joint: the first three are linear [m/s].
    fastest = max(fastest, float(np.abs(data.qvel.reshape(-1, 6)[:, :3]).max()))
bodies = {}
for number in range(1, model.nbody):
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.body_iquat[number])
    axes = turn.reshape(3, 3)
    bodies[model.body(number).name] = {
        "mass": float(model.body_mass[number]),
        "inertia": (axes @ np.diag(model.body_inertia[number]) @ axes.T).tolist(),
        "center": start[number].tolist(),
        "moved": float(np.linalg.norm(data.xipos[number] - start[number])),
    }
print(json.dumps({"bodies": bodies, "fastest": fastest, "depth": depth, "free": model.nv // 6}))
