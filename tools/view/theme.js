// Colours, of Okabe and Ito's palette where they carry meaning: people who are colour-blind tell them apart.

const kLight = {
  page: '#ffffff', scene: '#f3f4f6', ink: '#1c1e24', soft: '#5b606b', line: '#d5d8de', ground: '#c9ccd3', grid: '#b4b8c1',
  robot: '#7d9fc4', base: '#8d97a6', held: '#2b9e77', worlds: ['#b9b3a6', '#a9b3a0', '#c2aa9a', '#a8aeb8', '#bdb48f', '#b5a3ac'], deforming: '#b48cc0',
  start: '#0072b2', goal: '#d98a00', nearest: '#c8102e', proven: '#0072b2', measured: '#3f5d75', self: '#8c4fbf', margin: '#a03060', selected: '#f0c800', trail: '#009e73', search: '#8a6d3b',
};
const kDark = {
  page: '#15171b', scene: '#1b1e23', ink: '#eceef2', soft: '#a3a9b5', line: '#3a3e47', ground: '#33373f', grid: '#474c56',
  robot: '#6f9bc9', base: '#7b8696', held: '#35b58a', worlds: ['#968f80', '#868f7e', '#9d8878', '#858b96', '#98906c', '#92808a'], deforming: '#a878b8',
  start: '#56b4e9', goal: '#e69f00', nearest: '#ff5a5f', proven: '#56b4e9', measured: '#9fb6cb', self: '#b98be0', margin: '#e58ab0', selected: '#f0e442', trail: '#2fc79a', search: '#c9a86a',
};

export const joints = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#b39200', '#56b4e9', '#7c7c86', '#8c4fbf'];

const dark = window.matchMedia('(prefers-color-scheme: dark)');
export const colours = () => (dark.matches ? kDark : kLight);
export const onThemeChange = (then) => dark.addEventListener('change', then);
